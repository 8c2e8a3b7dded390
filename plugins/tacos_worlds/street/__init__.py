"""The scene `scene.street`: a procedural town and a car driving through it."""
