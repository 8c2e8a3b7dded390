"""Whether a simulator ranks real cameras as reality does, before and after what it lacked was added."""
