"""A world as one mesh, and the light that falls on it: baked once, whatever draws it."""
