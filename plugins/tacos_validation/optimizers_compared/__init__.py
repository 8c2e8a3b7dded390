"""Comparing optimizers on one design problem, with equal images."""
