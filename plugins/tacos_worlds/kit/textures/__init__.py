"""Procedural textures that tile without seams, synthesised with numpy.

Each function takes ``(rng, size)`` and returns a `Texture`. Detail spans several scales, from whole boards or
tiles down to single threads and pores, because feature detectors live on it.
"""
