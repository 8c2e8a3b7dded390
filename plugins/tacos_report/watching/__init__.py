"""``tacos watch``: a study while it runs, in the terminal or as a page that reloads itself."""
