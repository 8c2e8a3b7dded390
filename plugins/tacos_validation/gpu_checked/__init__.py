"""Whether the device in use renders what software renders, and how fast a study goes on it."""
