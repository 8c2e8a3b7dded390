"""Motion of an agent along a path, and the stretches of walks that become an episode."""
