"""Bayesian optimization with what is known of cameras: `PhysicalGp`."""
