"""Image formation: capture -> effects -> sensor -> effects -> frames."""
