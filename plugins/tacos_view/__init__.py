"""A look at scenes, cameras, effects and catalogs: ``tacos view``, and frames in one line of Python.

==================  ==========================================================================================
``recipes``         the study a user means: a recipe, a finished run, a scene by itself
``cameras``         the camera she means: a product, what a study designed, figures of her own
``setup``           that camera in the study's scenes, ready to take frames one by one
``rendering``       frames in memory, with depth, ids and poses: `render`
``notebook``        cameras in notebooks
``pictures``        arrays as pictures for people
``floor_plan``      a world from above, and the trip through it
``effect_ladder``   one frame with an effect at rising severities
``catalog_sheet``   parts of a catalog drawn to one scale
``pages``           PNG files and a page of them
==================  ==========================================================================================

Importing this package loads none of them: names are imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tacos_view.rendering import CameraFrames as CameraFrames
    from tacos_view.rendering import Rendering as Rendering
    from tacos_view.rendering import render as render
    from tacos_view.setup import RenderSetup as RenderSetup
    from tacos_view.setup import set_up as set_up

_HOME_OF = {
    "CameraFrames": "tacos_view.rendering",
    "RenderSetup": "tacos_view.setup",
    "Rendering": "tacos_view.rendering",
    "render": "tacos_view.rendering",
    "set_up": "tacos_view.setup",
}

__all__ = ["CameraFrames", "RenderSetup", "Rendering", "render", "set_up"]


if not TYPE_CHECKING:  # what is not above is an error to type checkers

    def __getattr__(name: str) -> Any:
        if name not in _HOME_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(_HOME_OF[name]), name)
