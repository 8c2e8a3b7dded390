"""Headless OpenGL rasterizer: baked light, physically based materials, exact depth and ids."""
