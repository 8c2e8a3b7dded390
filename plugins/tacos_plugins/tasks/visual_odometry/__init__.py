"""How well the motion of a camera follows from its images."""
