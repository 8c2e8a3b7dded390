"""Pure physics of cameras: arrays and numbers in, arrays and numbers out; no plugin machinery."""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
