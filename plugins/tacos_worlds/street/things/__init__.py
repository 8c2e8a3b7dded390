"""Things in the streets, each as a `Piece` around the origin on the ground."""
