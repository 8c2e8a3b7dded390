"""From captures to causes, with intervals, remainder and the capture to take next."""
