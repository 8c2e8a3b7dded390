"""The agent's way through the rooms: where to, along which path, and how the head moves."""
