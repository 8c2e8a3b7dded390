"""One component of each kind for tacos-framework."""
