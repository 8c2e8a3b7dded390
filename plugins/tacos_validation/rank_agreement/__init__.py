"""Rank agreement of a small study with the same study at full size."""
