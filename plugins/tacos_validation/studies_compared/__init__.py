"""Variants of a study side by side, over several seeds."""
