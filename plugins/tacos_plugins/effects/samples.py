"""Brings effects on samples, written for plain arrays, to a sensor's signal and to files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework.errors import Fault, UserError
from tacos_framework.values import (
    ContextMissing,
    Exposure,
    FrameBatch,
    ImageContext,
    ImageGeometry,
    Signal,
    View,
)
from tacos_plugins.effects.light import OnArray


def with_samples_changed(
    image: Signal, effect: OnArray, exposure: Exposure, rng: np.random.Generator
) -> Signal:
    """The signal with an effect of the stages pixel or readout; the signal itself where it is off."""
    samples = _on_view(effect, image.samples_dn, image, image.view, exposure, rng)
    return image if samples is image.samples_dn else replace(image, samples_dn=samples)


def with_files_changed(
    image: FrameBatch, effect: OnArray, exposure: Exposure, rng: np.random.Generator
) -> FrameBatch:
    """The frames with an effect of the stages isp or codec; the batch itself where it is off.

    Effects compute in floating point; the result is rounded and clipped to the range of the file.
    """
    files = []
    for file, view in zip(image.images, image.capture.views, strict=True):
        before = file.astype(np.float32)
        after = _on_view(effect, before, image, view, exposure, rng)
        files.append(file if after is before else _rounded(after, file, image.white_level_dn))
    same = all(after is before for after, before in zip(files, image.images, strict=True))
    return image if same else replace(image, images=tuple(files))


def _rounded(
    samples: NDArray[np.floating], file: NDArray[np.unsignedinteger], white_level_dn: float
) -> NDArray[np.unsignedinteger]:
    rounded = np.rint(samples)
    np.clip(rounded, 0, white_level_dn, out=rounded)
    return rounded.astype(file.dtype)


def _on_view(
    effect: OnArray,
    samples: NDArray[np.float32],
    image: Signal | FrameBatch,
    view: View,
    exposure: Exposure,
    rng: np.random.Generator,
) -> NDArray[np.floating]:
    context = ImageContext(
        exposure_s=exposure.time_s,
        gain_db=exposure.gain_db,
        f_number=exposure.f_number,
        black_level_dn=image.black_level_dn,
        white_level_dn=image.white_level_dn,
        depth_m=view.depth_m,
    )
    try:
        return effect.on_array(
            samples, geometry=ImageGeometry.of_camera(view.camera), context=context, rng=rng
        )
    except ContextMissing as missing:
        remedy = "Use a sensor that gives it, or take the effect out of the recipe."
        raise UserError(Fault(f"camera {view.camera.name!r}", str(missing), "", remedy)) from missing
