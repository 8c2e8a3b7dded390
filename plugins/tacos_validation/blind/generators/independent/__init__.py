"""Other makers of the same effects: packages of others, and shapes the catalogue's formulas do not have.

What needs a package of the extra ``blind`` names it; `available` leaves it out where it is absent.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass

from tacos_validation.blind.generators.catalogue import Withheld
from tacos_validation.blind.generators.independent.amplitude import SingleAmplitudeEffect
from tacos_validation.blind.generators.independent.colour import OtherCamera, WarmerLamp
from tacos_validation.blind.generators.independent.lenses import (
    AberratedPupil,
    OpenCvFocalLength,
    OpenCvPose,
    RealFringes,
)
from tacos_validation.blind.generators.independent.optics import (
    FisheyeLens,
    FluorescentTube,
    HandShake,
    Hexagon,
    NaturalFallOff,
    RealLens,
    SideLamp,
    WidePsf,
)
from tacos_validation.blind.generators.independent.pixels import (
    AvalancheGain,
    BlockReadout,
    ChargeDiffusion,
    ClampedPedestal,
    ErfShading,
    HeavyTailedOffsets,
    UnevenCodes,
    UnevenDarkCurrent,
    UnevenFullWells,
)
from tacos_validation.blind.generators.independent.processing import (
    Menon,
    NonLocalMeans,
    PhotographersJpeg,
    PillowUnsharp,
    SrgbMixed,
    TotalVariation,
)
from tacos_validation.blind.generators.independent.sensing import (
    DriftingRows,
    LognormalPixels,
    SoftFullWell,
    TelegraphNoise,
)


@dataclass(frozen=True)
class Variant:
    """Another maker of an effect."""

    effect: str
    entry: Withheld
    package: str = ""


def _of(
    cls: type[SingleAmplitudeEffect],
    low: float,
    high: float,
    largest: float,
    package: str = "",
    colour: bool = False,
    natural: bool = True,
) -> Variant:
    return Variant(cls.name, Withheld(lambda a, r: cls(a), (low, high), largest, colour, natural), package)


VARIANTS: Mapping[str, Variant] = {
    "natural fall-off": _of(NaturalFallOff, 0.05, 0.6, 1.0),
    "OpenCV fisheye": _of(FisheyeLens, 0.05, 0.6, 1.0),
    "lensfun lens": _of(RealLens, 0.0, 2.0, 2.0, "lensfunpy"),
    "hexagonal aperture": _of(Hexagon, 0.7, 3.0, 6.0),
    "hand shake": _of(HandShake, 1.5, 8.0, 16.0),
    "wide stray light": _of(WidePsf, 0.01, 0.1, 0.3),
    "fluorescent tube": _of(FluorescentTube, 0.02, 0.3, 0.6),
    "soft full well": _of(SoftFullWell, 0.05, 0.4, 1.0),
    "telegraph noise": _of(TelegraphNoise, 0.5, 3.0, 8.0),
    "drifting rows": _of(DriftingRows, 0.1, 1.0, 5.0),
    "lognormal pixels": _of(LognormalPixels, 0.003, 0.02, 0.1),
    "sRGB curve": _of(SrgbMixed, 0.03, 0.5, 1.0),
    "Pillow unsharp mask": _of(PillowUnsharp, 0.1, 1.0, 2.5),
    "non-local means": _of(NonLocalMeans, 1.0, 6.0, 12.0),
    "total variation": _of(TotalVariation, 0.3, 2.0, 6.0, "skimage"),
    "Menon demosaicing": _of(Menon, 1.0, 1.0, 1.0, "colour_demosaicing", colour=True),
    "editor's JPEG": _of(PhotographersJpeg, 0.1, 4.0, 4.9),
    "side lamp": _of(SideLamp, 0.05, 0.5, 1.5),
    "lensfun fringes": _of(RealFringes, 1.0, 8.0, 40.0, "lensfunpy", colour=True),
    "aberrated pupil": _of(AberratedPupil, 0.8, 3.0, 8.0),
    "OpenCV pose": _of(OpenCvPose, 0.05, 0.5, 2.0),
    "OpenCV camera matrix": _of(OpenCvFocalLength, 0.002, 0.03, 0.06),
    "warmer lamp": _of(WarmerLamp, 0.05, 0.5, 1.0, colour=True),
    "another camera's filters": _of(OtherCamera, 0.05, 0.6, 1.0, colour=True),
    "avalanche gain": _of(AvalancheGain, 0.05, 0.5, 2.0),
    "uneven full wells": _of(UnevenFullWells, 0.03, 0.2, 0.35),
    "uneven dark current": _of(UnevenDarkCurrent, 1.0, 60.0, 400.0, natural=False),
    "heavy-tailed offsets": _of(HeavyTailedOffsets, 0.2, 2.0, 8.0),
    "charge diffusion": _of(ChargeDiffusion, 0.003, 0.03, 0.08),
    "uneven codes": _of(UnevenCodes, 2.0, 4.0, 8.0),
    "clamped pedestal": _of(ClampedPedestal, 0.5, 6.0, 12.0),
    "block readout": _of(BlockReadout, 20.0, 80.0, 120.0),
    "erf shading table": _of(ErfShading, 0.2, 1.5, 2.5),
}
"""Other makers, by name."""


def available() -> list[str]:
    return [
        name
        for name, v in VARIANTS.items()
        if not v.package or importlib.util.find_spec(v.package) is not None
    ]
