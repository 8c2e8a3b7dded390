"""Rank agreement of a simulator with real cameras, before and after what it lacked was added."""
