"""Targets that need no simulation: what pictures of a wall, an edge, a chart, a bracket expect of themselves."""
