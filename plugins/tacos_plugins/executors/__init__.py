"""Default executors."""
