"""Shared parts of tasks on pairs of images: the geometry of the pair, and the scores of its depth."""
