"""Design cameras for vision tasks in simulation, as a pipeline of plugins.

This is the one door for those who write recipes in Python, embed the library or write plugins: the way in
(`run`, `load_recipe`, `Plugins`), the contract of each kind of component, and the values that cross ports.
``__init__.pyi`` lists the names; a module is imported when one of its names is first used.
"""

from __future__ import annotations

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
