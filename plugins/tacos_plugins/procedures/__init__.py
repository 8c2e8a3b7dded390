"""Default procedures."""
