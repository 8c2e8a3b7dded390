"""Evaluation on a Ray cluster: this machine, or many."""
