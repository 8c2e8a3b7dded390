"""Pictures without OpenGL, by compiled loops: which triangle a pixel sees, then its shading."""
