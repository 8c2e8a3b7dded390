"""People: bodies of a height and a build, in a pose and in clothes."""
