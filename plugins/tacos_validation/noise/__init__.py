"""Measuring a camera's noise, and holding the simulated noise against its model."""
