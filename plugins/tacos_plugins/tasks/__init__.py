"""Default tasks."""
