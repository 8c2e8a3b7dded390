"""Comparison of the device in use with software rendering: equal pictures, and the speed of a study."""
