"""Files beside a world: recorded poses, panoramas."""
