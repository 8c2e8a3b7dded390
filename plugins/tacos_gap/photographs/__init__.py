"""Photographs turned into a folder of captures: what their files say, and what they show."""
