"""Default optimizers."""
