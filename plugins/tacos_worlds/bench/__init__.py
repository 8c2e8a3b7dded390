"""Scenes of a measuring bench: a target in front of a camera that stands still."""
