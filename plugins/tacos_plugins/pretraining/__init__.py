"""Pre-training a task that learns on images of our own scenes."""
