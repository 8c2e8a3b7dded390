"""Whether exposures replayed from one exposure of a recording rank as the real ones do."""
