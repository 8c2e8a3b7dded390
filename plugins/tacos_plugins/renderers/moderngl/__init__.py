"""Headless OpenGL rasterizer: physically based materials, exact depth and ids."""
