"""Default effects."""
