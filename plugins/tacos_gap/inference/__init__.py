"""Fit of hypotheses to the evidence, and their parameters."""
