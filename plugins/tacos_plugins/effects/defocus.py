"""Things that are not at the distance of focus."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import median
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from tacos_framework import (
    Captures,
    ImageContext,
    ImageGeometry,
    LookAlike,
    Settings,
    ShownBy,
    Stage,
    physical,
    setting,
    structured,
)
from tacos_plugins.effects import observations
from tacos_plugins.effects.blur import blur, disc_transfer, kernel_of
from tacos_plugins.effects.depth_of_field import LARGEST_RADIUS_PX, blur_by_depth, signed_radius
from tacos_plugins.effects.disc import disc_kernel
from tacos_plugins.effects.disc_radius import BLURRED, SHARP, disc_of
from tacos_plugins.effects.edge_spread import are_sharpened
from tacos_plugins.effects.field_blur import blur_over_field
from tacos_plugins.effects.focus_plane import tilted_plane
from tacos_plugins.effects.samples import Samples
from tacos_plugins.effects.shown_by import EDGES

LAMP, LAMPS_SHARE = 4.0, 0.01
"""A lamp is so many times brighter than all but that share of a frame's samples; white print is not."""

_STRIDE = 4  # pixels from one to the next that are looked at


class Defocus:
    """Spreads each point of light over an even disc.

    The disc has one radius all over the image, or one that grows along a line, as where a flat thing or the
    sensor is tilted by t against the plane of focus: with a slope of tan(t) / (2 N) at f-number N, through
    sharpness to the other side of focus. Or it follows from the distance of focus, the f-number and the depth
    of each pixel, for a thin lens. Then near, blurred things overlap what is behind them, and what is
    behind does not bleed into sharp things before it; what they hide is not known and is made up from its
    surroundings. The image does not change size with focus.

    A disc of one radius has the contrast of the disc, 2 J1(z) / z with z = 2 pi R f, at every frequency f
    that pixels hold. Where depth decides, layers are masks that may not be negative, and each pixel gets its
    share of a disc: below two pixels that leaves too much contrast near the Nyquist frequency.

    Source: Potmesil and Chakravarty 1981, "A lens and aperture camera model for synthetic image generation",
    SIGGRAPH: the circle of confusion.
    """

    class Config(Settings):
        radius_px: float = setting(
            0.0, help="Radius of the disc all over the image.", unit="px", ge=0, le=100
        )
        radius_um: float | None = physical(
            "radius_px",
            help="Radius of the disc on the sensor, in place of radius_px.",
            unit="um",
            ge=0,
            le=1e3,
        )
        slope_x: float = setting(
            0.0,
            help="Growth of the radius from the principal point to the right, over the way.",
            unit="px/px",
            ge=-0.5,
            le=0.5,
        )
        slope_y: float = setting(
            0.0, help="Growth of the radius downwards, over the way.", unit="px/px", ge=-0.5, le=0.5
        )
        focus_m: float | None = setting(
            None,
            help="Distance of focus; if given, the radius follows from the depth of each pixel.",
            unit="m",
            gt=0,
            le=1e6,
            also=("focus", "defocus"),
        )
        f_number: float | None = setting(
            None, help="Focal length over aperture for `focus_m`; by default the exposure's.", gt=0.3, le=200
        )

        @model_validator(mode="after")
        def _one_radius(self) -> Defocus.Config:
            for name in ("radius_px", "radius_um", "slope_x", "slope_y"):
                if getattr(self, name) and self.focus_m is not None:
                    raise ValueError(f"{name} and focus_m exclude each other: give one radius, or a focus")
            return self

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 30
    neutral: ClassVar[Mapping[str, Any]] = {
        "radius_px": 0.0,
        "slope_x": 0.0,
        "slope_y": 0.0,
        "focus_m": None,
    }
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"radius_px": 1.5}, {"radius_px": 4.0})
    by_capture: ClassVar[Sequence[str]] = ("radius_px",)
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "lens-blur",
            observations.one_depth_one_place,
            "edge",
            "edges over the whole field: blur of the lens grows towards the corners",
        ),
        LookAlike(
            "lens-blur",
            are_sharpened,
            "edge",
            "the same edges as RAW or unsharpened files: sharpening hides which blur was there before it",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (EDGES,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The radius that the spectra of pictures show beside those expected; the middle one of several.

        And the tilted plane that the radii of tiles lie in, of the picture that discs explain best.
        """
        discs = [(disc, each) for each in structured(captures) if (disc := disc_of(each)) is not None]
        if radii := [disc.radius_px for disc, _ in discs if disc.left < BLURRED]:
            yield {"radius_px": float(median(radii))}
        not_sharp = [(disc.left, each) for disc, each in discs if disc.left < SHARP]
        if not_sharp and (plane := tilted_plane(min(not_sharp, key=lambda pair: pair[0])[1])) is not None:
            yield {"radius_px": plane.radius_px, "slope_x": plane.slope_x, "slope_y": plane.slope_y}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        """Light out of focus; `focus_m` needs the context's depth and f-number."""
        c = self.config
        if c.focus_m is not None:
            depth_m = context.known_depth_m("effect.defocus with focus_m")
            f_number = c.f_number or context.known_f_number("effect.defocus with focus_m")
            radius = signed_radius(depth_m, geometry, f_number=f_number, focus_m=c.focus_m)
            return blur_by_depth(signal, np.broadcast_to(radius, signal.shape[:3]))
        if c.slope_x or c.slope_y:
            radius = np.abs(c.radius_px + c.slope_x * geometry.x_px + c.slope_y * geometry.y_px)
            radius = np.minimum(radius, LARGEST_RADIUS_PX)
            return _spread(signal, lambda light, kernel: blur_over_field(light, radius, kernel))
        return spread_over_disc(signal, c.radius_px) if c.radius_px else signal


def spread_over_disc(light: NDArray[np.floating], radius_px: float) -> NDArray[np.floating]:
    """Light spread over an even disc.

    By the disc's transfer function, whose kernel has negative lobes, as every band limit has; but what lamps
    have beyond the rest of their frame by the pixels' shares of a disc, so that they have no rings.

    `light`: (N, H, W, C) light in any unit, 0 where there is none. `radius_px`: R, above 0 [px].

    Returns: same shape and dtype.
    """
    return _spread(light, lambda light, kernel: blur(light, kernel(radius_px)))


def _spread(
    light: NDArray[np.floating],
    by: Callable[[NDArray[np.floating], Callable[[float], NDArray[np.float64]]], NDArray[np.floating]],
) -> NDArray[np.floating]:
    """Light spread `by` kernels of discs: of lamps by shares of pixels, else by the transfer function."""
    seen = np.minimum(light, _brightest_but_for_lamps(light))
    beyond = light - seen
    spread = by(seen, lambda radius_px: kernel_of(disc_transfer(radius_px), reach_px=radius_px))
    return spread + by(beyond, disc_kernel) if beyond.any() else spread


def _brightest_but_for_lamps(light: NDArray[np.floating]) -> NDArray[np.floating]:
    """(N, 1, 1, 1) light beyond which something is a lamp: it is rare, and far brighter than all else."""
    some = light[:, ::_STRIDE, ::_STRIDE]
    bright = np.quantile(some, 1 - LAMPS_SHARE, axis=(1, 2, 3), keepdims=True)
    return (LAMP * bright).astype(light.dtype)
