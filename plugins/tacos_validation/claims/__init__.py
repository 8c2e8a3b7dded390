"""Sentences about cameras or searches, tested over many seeds."""
