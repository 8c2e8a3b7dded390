"""Rank agreement of two simulators, or of a simulator with what stands for reality."""
