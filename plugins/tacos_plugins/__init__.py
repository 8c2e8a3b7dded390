"""The default plugins of tacos-framework; an ordinary plugin package."""
