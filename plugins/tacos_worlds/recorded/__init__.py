"""Recordings of real cameras: frames with exposures and times, their light and their motion."""
