"""Files that hold worlds, read into :class:`tacos_worlds.imported.model.Model`."""
