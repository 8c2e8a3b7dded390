"""THE image formation: capture -> effects -> sensor -> effects -> frames. Studies and diagnosis both call it.

==================  ========================================================================================
``placed``          effects and sensors as a recipe places them: for all cameras, or with settings per camera
``image_units``     an effect's lengths and charges in the pixels and digital numbers of an image
``chain``           the effects of one image at their places
``checked``         arrays that are not finite, refused with who made them so
``draws``           what is drawn and remembered along an episode, frame by frame
``arrays``          from light or expected samples to the values of a file, on arrays
``controlled``      the loop from a frame to the exposure of the next
``lenses``          any lens from pinhole pictures: how renderers are called
``lens_faces``      the sides of a cube, and how an image is put together from them
``views``           effects on the light of rendered views, truth moved along
``image_formation`` all of it for captures and frames, as a study calls it
``wanted``          frames as a task wants them: linear, coded, grey
==================  ========================================================================================

Expected light passes the effects of the stages scene, optics, exposure and pixel; then comes the noise.
Noisy samples pass those of the readout, are rounded and clipped, and pass isp and codec. Effects before the
noise do not correlate it, those after it do.
"""

from __future__ import annotations

from tacos_framework.formation.arrays import SensorAt, form_files
from tacos_framework.formation.chain import ActingEffect, EffectChain
from tacos_framework.formation.draws import EpisodeDraws
from tacos_framework.formation.image_formation import ImageFormation
from tacos_framework.formation.image_units import in_image_units
from tacos_framework.formation.lenses import captured
from tacos_framework.formation.placed import PlacedControl, PlacedEffect, PlacedSensor
from tacos_framework.formation.wanted import as_wanted, frames_for, shown

__all__ = [
    "ActingEffect",
    "EffectChain",
    "EpisodeDraws",
    "ImageFormation",
    "PlacedControl",
    "PlacedEffect",
    "PlacedSensor",
    "SensorAt",
    "as_wanted",
    "captured",
    "form_files",
    "frames_for",
    "in_image_units",
    "shown",
]
