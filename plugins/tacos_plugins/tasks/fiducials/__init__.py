"""Markers read by a camera: which, from how far, and where they are."""
