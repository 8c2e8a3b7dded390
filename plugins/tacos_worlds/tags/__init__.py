"""Markers with known places in any world: for cameras that find their way by them."""
