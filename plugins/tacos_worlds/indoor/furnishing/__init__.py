"""Furniture of rooms, and its places."""
