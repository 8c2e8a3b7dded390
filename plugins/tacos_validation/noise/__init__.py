"""Holding the simulated noise against its model."""
