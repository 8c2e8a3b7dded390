"""Pure physics of cameras: arrays and numbers in, arrays and numbers out; no plugin machinery."""
