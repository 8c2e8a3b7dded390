"""Effects of a lens that is known by its prescription."""
