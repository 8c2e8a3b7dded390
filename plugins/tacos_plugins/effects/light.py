"""Brings effects on light, written for plain arrays, to the views of a capture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.motion import Places, inverse_depth
from tacos_framework.camera.resampling import nearest, resample, resample_inverse_depth
from tacos_framework.values import Capture, Exposure, ImageContext, ImageGeometry, View


class OnArray(Protocol):
    """The part of an effect that works on plain arrays."""

    def on_array(
        self,
        signal: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[np.floating]:
        """See `tacos_framework.contracts.Effect`."""
        ...


def with_light_changed(
    image: Capture, effect: OnArray, exposure: Exposure, rng: np.random.Generator
) -> Capture:
    """The capture with an effect on the light of every view, truth left as it is.

    The capture itself where the effect hands every array on.
    """
    views = []
    for view in image.views:
        light = effect.on_array(
            view.luminance_cd_m2,
            geometry=ImageGeometry.of_camera(view.camera),
            context=ImageContext.of_light(view, exposure),
            rng=rng,
        )
        views.append(view if light is view.luminance_cd_m2 else replace(view, luminance_cd_m2=light))
    same = all(after is before for after, before in zip(views, image.views, strict=True))
    return image if same else replace(image, views=tuple(views))


Source = Callable[[View], Places]
"""Gives where in a view each pixel of the changed image looks, (H, W) or (N, H, W) columns and rows [px]."""

Nearness = Callable[[View, Places, NDArray[np.floating]], NDArray[np.floating]]
"""Takes one over the depth that was fetched from those places to that of the changed image [1/m]."""


def with_pixels_moved(image: Capture, source: Source, nearness: Nearness | None = None) -> Capture:
    """The capture with light, depth and object ids fetched from elsewhere, so that truth stays true.

    The camera stays the pinhole that tasks believe in.
    """
    return replace(image, views=tuple(_moved(view, source(view), nearness) for view in image.views))


def _moved(view: View, places: Places, nearness: Nearness | None) -> View:
    near = resample_inverse_depth(inverse_depth(view.depth_m), *places)
    if nearness is not None:
        near = nearness(view, places, near)
    with np.errstate(divide="ignore"):
        depth_m = 1.0 / near
    return replace(
        view,
        luminance_cd_m2=resample(view.luminance_cd_m2, *places),
        depth_m=depth_m.astype(np.float32),
        object_id=nearest(view.object_id, *places),
    )
