"""Whether a small study ranks cameras as the same study at full size does."""
