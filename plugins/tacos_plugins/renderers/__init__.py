"""Default renderers."""
