"""What renderers that trace rays share: the moments of an exposure, the world at them, truth along rays."""
