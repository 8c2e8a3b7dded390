"""Procedural furnished rooms, and a walk through them."""
