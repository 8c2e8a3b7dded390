"""Small things that stand on furniture, each as a `Piece` that stands on z = 0."""
