"""Targets that need no simulation: wall, edge, chart and bracket expect of themselves what they are."""
