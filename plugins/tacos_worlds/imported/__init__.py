"""`scene.imported`: a room, a building or a street of the user's own, from a file."""
