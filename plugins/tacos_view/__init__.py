"""A look at scenes, cameras, effects and catalogs: ``tacos view``, and frames in one line of Python.

==================  ==========================================================================================
``recipes``         the study a user means: a recipe, a finished run, a scene by itself
``cameras``         the camera she means: a product, what a study designed, figures of her own
``setup``           that camera in the study's scenes, ready to take frames one by one
``rendering``       frames in memory, with depth, ids and poses: `render`
``pictures``        arrays as pictures for people
``floor_plan``      a world from above, and the trip through it
``effect_ladder``   one frame with an effect at rising severities
``catalog_sheet``   parts of a catalog drawn to one scale
``pages``           PNG files and a page of them
==================  ==========================================================================================
"""

from __future__ import annotations

from tacos_view.rendering import CameraFrames, Rendering, render
from tacos_view.setup import RenderSetup, set_up

__all__ = ["CameraFrames", "RenderSetup", "Rendering", "render", "set_up"]
