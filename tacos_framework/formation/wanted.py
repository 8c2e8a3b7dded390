"""Frames as a task wants them: linear, coded for a display in 8 bits, or grey in 8 bits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.colour import display_image
from tacos_framework.contracts import TaskBase, Wanted, optional
from tacos_framework.values import FrameBatch

LUMA_WEIGHTS = (0.299, 0.587, 0.114)
"""Shares of coded red, green and blue in luma (ITU-R BT.601), as `cv2.cvtColor` weighs them."""


def as_wanted(frames: FrameBatch, wants: Wanted | None) -> FrameBatch:
    """Frames as a task wants them; those that are so already, or of a task that takes any, as they are.

    Linear files become 8 bits by the curve of sRGB; coded ones of more bits are rounded to 8.

    Returns: for ``coded`` and ``grey`` uint8 from 0, black, to 255.
    """
    if wants is None or wants == "linear":
        return frames
    codes = _codes_of_levels(frames)
    images = frames.images if codes is None else tuple(codes[image] for image in frames.images)
    return replace(
        frames,
        images=tuple(_grey(image) for image in images) if wants == "grey" else images,
        black_level_dn=0.0,
        white_level_dn=255.0,
        dn_per_electron=(),
        coded=True,
    )


def frames_for(task: object, frames: FrameBatch) -> FrameBatch:
    """Frames as a task wants them, by what it declares."""
    return as_wanted(frames, optional(task, TaskBase, "wants"))


def shown(frames: FrameBatch) -> list[NDArray[np.uint8]]:
    """For each camera its (N, H, W, C) frames as people expect to see them, 0..255."""
    return list(as_wanted(frames, "coded").images)  # type: ignore[arg-type]


def _codes_of_levels(frames: FrameBatch) -> NDArray[np.uint8] | None:
    """(levels,) the 8-bit code of each value of a file; None where they are the codes already."""
    black_dn, white_dn = frames.black_level_dn, frames.white_level_dn
    if frames.coded and (black_dn, white_dn) == (0.0, 255.0):
        return None
    levels = np.arange(np.iinfo(frames.images[0].dtype).max + 1)
    return display_image(levels, black_dn, white_dn, coded=frames.coded)


def _grey(coded: NDArray[Any]) -> NDArray[np.uint8]:
    if coded.shape[-1] == 1:
        return coded
    luma = coded @ np.array(LUMA_WEIGHTS, np.float32)
    return np.rint(luma).astype(np.uint8)[..., None]
