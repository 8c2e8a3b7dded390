"""Default scenes."""
