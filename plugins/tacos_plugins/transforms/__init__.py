"""Default transforms."""
