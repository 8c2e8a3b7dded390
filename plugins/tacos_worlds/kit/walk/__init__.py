"""How an agent walks along a path, and which stretches of walks become an episode."""
