"""Drawings of reports."""
