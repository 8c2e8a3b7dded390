"""Motion of a camera from its images."""
