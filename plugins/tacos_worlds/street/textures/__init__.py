"""Procedural textures of the street, synthesised with numpy, with detail from metres down to centimetres.

Each function takes ``(rng, size)`` and returns a `Texture`, as those of `scenes.indoor.textures` do.
"""
