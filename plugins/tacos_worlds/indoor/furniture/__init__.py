"""Parametric furniture: one module a family, each a function ``(rng, style) -> Piece``."""
