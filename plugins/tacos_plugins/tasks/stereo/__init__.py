"""What tasks on pairs of images have in common: the geometry of the pair, and the scores of its depth."""
