"""Default exposure controls."""
