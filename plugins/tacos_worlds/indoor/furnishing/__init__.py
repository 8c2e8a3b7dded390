"""Which furniture a room gets, and where it stands."""
