"""Rank agreement of exposures replayed from one exposure of a recording with the real ones."""
