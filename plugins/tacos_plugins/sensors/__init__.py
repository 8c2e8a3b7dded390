"""Default sensors."""
