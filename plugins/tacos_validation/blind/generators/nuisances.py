"""Disturbances of real captures beside any effect: poses, lamps, focus, references and files.

A simulation is never given the pose, the lamp and the focus of a capture exactly. Here the real side is off,
and what the simulator expects is left as it believes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from tacos_validation.blind.generators import processing_effects as processing
from tacos_validation.blind.generators.acquisitions import Acquisition
from tacos_validation.blind.generators.camera import IdealCamera
from tacos_validation.blind.generators.capture_nuisance import CaptureNuisance
from tacos_validation.blind.generators.catalogue import CATALOGUE
from tacos_validation.blind.generators.injected_effect import InjectedEffect

PIPELINE = ("tone-curve", "denoise", "sharpening", "jpeg")
"""What a camera does that hands out finished pictures."""

SEEN_BESIDE_PIPELINE = frozenset(
    {"vignetting", "illumination-gradient", "lens-distortion", "flicker", "rolling-shutter", "motion-blur"}
)
"""Effects whose traces a processed picture keeps."""

UNEVEN = 0.04
"""Largest slope of a lamp's light over the image, relative."""


@dataclass(frozen=True)
class Nuisance:
    """Largest disturbances; each capture draws its own."""

    shift_px: float = 0.0
    turn_deg: float = 0.0
    lamp: float = 0.0  # the light is off by this share, and uneven; declared as ``level_uncertainty``
    expected_frames: tuple[int, int] | None = None
    """The expectation is the mean of between so many noisy frames; declared as ``simulated_frames``."""
    defocus_px: float = 0.0  # radius of the disc by which the focus is off [px]
    pedestal: bool = True  # true if files have one
    file_quality: tuple[int, int] | None = None  # files are JPEG, between these qualities; None for PNG
    pipeline: bool = False  # true if the camera processes its pictures, by `PIPELINE`, for all captures alike
    may_be_called: tuple[str, ...] = ()  # effects that an answer may name for it, beside what is withheld
    veils: frozenset[str] = frozenset()  # effects that cannot be told beside it

    @property
    def effects(self) -> tuple[str, ...]:
        return PIPELINE if self.pipeline else ()

    def bears(self, effects: Collection[str]) -> tuple[str, ...]:
        """Those of some effects that can still be told beside it."""
        return tuple(name for name in effects if name not in self.veils)


_POSE = frozenset({"pose-error", "focal-length-error"})
_LIGHT = frozenset({"exposure-error", "illumination-gradient"})
_BLUR = frozenset({"defocus", "lens-blur", "motion-blur"})

NUISANCES: Mapping[str, Nuisance] = {
    "misregistered": Nuisance(
        shift_px=1.0, turn_deg=0.2, may_be_called=("pose-error", "focal-length-error"), veils=_POSE
    ),
    "lamp": Nuisance(lamp=0.1, may_be_called=("exposure-error", "illumination-gradient"), veils=_LIGHT),
    "few frames": Nuisance(expected_frames=(2, 5)),
    "focus": Nuisance(defocus_px=0.8, may_be_called=("defocus", "lens-blur"), veils=_BLUR),
    "no pedestal": Nuisance(pedestal=False),
    "lossy files": Nuisance(
        file_quality=(85, 95), may_be_called=("jpeg",), veils=frozenset({"jpeg", "quantisation"})
    ),
    "processed": Nuisance(pipeline=True, veils=frozenset(CATALOGUE) - SEEN_BESIDE_PIPELINE),
    "desk": Nuisance(
        shift_px=0.7,
        turn_deg=0.1,
        lamp=0.05,
        expected_frames=(3, 6),
        defocus_px=0.5,
        may_be_called=(*sorted(_POSE), *sorted(_LIGHT), "defocus", "lens-blur"),
        veils=_POSE | _LIGHT | _BLUR,
    ),
}
"""Nuisances by name; ``desk`` is what somebody meets who photographs a desk and simulates it."""


def without_pedestal(camera: IdealCamera, nuisance: Nuisance) -> IdealCamera:
    return camera if nuisance.pedestal else replace(camera, black_dn=0.0)


def pipeline_of(nuisance: Nuisance, rng: np.random.Generator) -> tuple[InjectedEffect, ...]:
    if not nuisance.pipeline:
        return ()
    return (
        processing.InjectedToneCurve(float(rng.uniform(0.55, 0.8))),
        processing.InjectedDenoising(float(rng.uniform(0.4, 1.5))),
        processing.InjectedSharpening(float(rng.uniform(0.3, 1.0)), float(rng.uniform(0.8, 1.5))),
        processing.InjectedJpeg(int(rng.integers(80, 95)), str(rng.choice(["4:4:4", "4:2:0"]))),
    )


def drawn(
    nuisance: Nuisance, acquisitions: Sequence[Acquisition], rng: np.random.Generator
) -> dict[str, CaptureNuisance]:
    """Disturbances of each capture, by its id; captures of one group share them."""
    by_group: dict[str, CaptureNuisance] = {}
    found = {}
    for acquisition in acquisitions:
        own = _drawn(nuisance, acquisition, rng)
        found[acquisition.id] = by_group.setdefault(acquisition.group, own) if acquisition.group else own
    return found


def _drawn(nuisance: Nuisance, acquisition: Acquisition, rng: np.random.Generator) -> CaptureNuisance:
    shift, turn, gain, slope, radius = (
        rng.uniform(-1, 1, 2),
        rng.uniform(-1, 1),
        rng.uniform(-1, 1),
        rng.uniform(-1, 1, 3),
        rng.uniform(0.3, 1),
    )
    quality = nuisance.file_quality and int(rng.integers(*nuisance.file_quality, endpoint=True))
    frames = int(rng.integers(*nuisance.expected_frames, endpoint=True)) if nuisance.expected_frames else 0
    if acquisition.kind == "dark":  # neither light nor place
        return CaptureNuisance(file_quality=quality)
    seen = acquisition.kind != "board"  # of which nothing is expected
    sx, sy = (nuisance.shift_px * shift / np.sqrt(2)).tolist()
    return CaptureNuisance(
        shift_px=(sx, sy),
        turn_deg=nuisance.turn_deg * turn,
        gain=1 + nuisance.lamp * gain,
        slope=tuple((UNEVEN * slope).tolist()) if nuisance.lamp else (0.0, 0.0, 0.0),
        level_uncertainty=nuisance.lamp if seen else 0.0,
        expected_frames=frames if seen else 0,
        defocus_px=nuisance.defocus_px * radius,
        file_quality=quality,
    )


def described(
    off: Mapping[str, CaptureNuisance], pipeline: Sequence[InjectedEffect]
) -> dict[str, dict[str, Any]]:
    return {
        "captures": {name: asdict(each) for name, each in off.items()},
        "pipeline": {effect.name: effect.parameters for effect in pipeline},
    }
