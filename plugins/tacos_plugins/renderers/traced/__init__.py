"""Shared by renderers that trace rays: the moments of an exposure, the world at them, truth along rays."""
