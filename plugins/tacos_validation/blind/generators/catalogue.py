"""The effects that are withheld, each at an amplitude between nothing and the worst met in the field."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tacos_validation.blind.generators import geometric_effects as geometry
from tacos_validation.blind.generators import light_effects as light
from tacos_validation.blind.generators import processing_effects as processing
from tacos_validation.blind.generators import sensor_effects as sensor
from tacos_validation.blind.generators.injected_effect import InjectedEffect

Build = Callable[[float, np.random.Generator], InjectedEffect]


@dataclass(frozen=True)
class Withheld:
    build: Build
    """Makes the effect of an amplitude; the generator draws what amplitude leaves open (signs, directions,
    shapes) and is seeded alike for every amplitude of a case."""
    field: tuple[float, float]
    """Amplitudes met in the field, 5th and 95th percentile of gap.md's table, or what is usual where it has
    none."""
    largest: float  # amplitude beyond which no camera is shipped
    colour: bool = False
    natural: bool = True
    """True if pictures of natural scenes alone can tell it: no dark frames, no exposure series, no boards."""
    captures: str = ""  # the set of captures that shows it; any if empty


def _sign(rng: np.random.Generator) -> float:
    return 1.0 if rng.random() < 0.5 else -1.0


def _factor(a: float, rng: np.random.Generator) -> float:
    """Up or down by the same ratio."""
    return float(np.exp(_sign(rng) * a))


def _direction(rng: np.random.Generator, size: int) -> np.ndarray:
    drawn = rng.standard_normal(size)
    return np.asarray(drawn / np.linalg.norm(drawn))


def _vignetting(a: float, rng: np.random.Generator) -> InjectedEffect:
    shares = rng.dirichlet([4.0, 2.0, 1.0])
    return light.InjectedVignetting(*(-a * shares).tolist())


def _gradient(a: float, rng: np.random.Generator) -> InjectedEffect:
    return light.InjectedIlluminationGradient(*(a * _direction(rng, 2)).tolist())


def _distortion(a: float, rng: np.random.Generator) -> InjectedEffect:
    # a is the displacement in the corner over the radius there; rho there is about 0.6
    sign = -1.0 if rng.random() < 0.7 else 1.0
    return geometry.InjectedLensDistortion(k1=sign * a / 0.36)


def _focal_length_error(a: float, rng: np.random.Generator) -> InjectedEffect:
    scale = 1 + _sign(rng) * a
    dx, dy = 60 * a * rng.uniform(-1, 1, size=2)
    return geometry.InjectedFocalLengthError(scale, float(dx), float(dy))


def _chromatic_aberration(a: float, rng: np.random.Generator) -> InjectedEffect:
    return geometry.InjectedLateralChromaticAberration(*(a * _direction(rng, 4)).tolist())


def _pose_error(a: float, rng: np.random.Generator) -> InjectedEffect:
    turn, shift = a * _direction(rng, 3), 4 * a * _direction(rng, 3)
    return geometry.InjectedPoseError(*turn.tolist(), *shift.tolist())


def _lens_blur(a: float, rng: np.random.Generator) -> InjectedEffect:
    return light.InjectedLensBlur(a, float(rng.choice([0.0, rng.uniform(0.5, 1.5)])))


def _motion_blur(a: float, rng: np.random.Generator) -> InjectedEffect:
    return light.InjectedMotionBlur(a, float(rng.uniform(0, 180)))


def _row_noise(a: float, rng: np.random.Generator) -> InjectedEffect:
    return sensor.InjectedRowNoise(a, a * float(rng.choice([0.0, 0.5])))


def _dsnu(a: float, rng: np.random.Generator) -> InjectedEffect:
    return sensor.InjectedDsnu(a, a * float(rng.choice([0.0, 0.4])))


def _defect_lines(a: float, rng: np.random.Generator) -> InjectedEffect:
    return sensor.InjectedDefectLines(a, int(rng.integers(1, 4)), int(rng.integers(0, 2)))


def _dark_current(a: float, rng: np.random.Generator) -> InjectedEffect:
    return sensor.InjectedDarkCurrent(a, min(a * float(rng.uniform(1e-6, 1e-5)), 1e-3))


def _saturation(a: float, rng: np.random.Generator) -> InjectedEffect:
    return sensor.InjectedSaturation(round(255 * (1 - a), 1))


def _nonlinearity(a: float, rng: np.random.Generator) -> InjectedEffect:
    share = rng.uniform(0.4, 1.0)
    return sensor.InjectedNonlinearity(-a * float(share), -a * float(1 - share))


def _quantisation(a: float, rng: np.random.Generator) -> InjectedEffect:
    step = max(1, round(a))
    if step == 1:
        return sensor.InjectedQuantisation(1.0, "floor")
    return sensor.InjectedQuantisation(float(step), str(rng.choice(["nearest", "floor"])))


def _white_balance(a: float, rng: np.random.Generator) -> InjectedEffect:
    red, blue = np.exp(a * _direction(rng, 2))
    return processing.InjectedWhiteBalance(float(red), float(blue))


def _colour_matrix(a: float, rng: np.random.Generator) -> InjectedEffect:
    off = a * rng.uniform(-1.0, 0.2, size=(3, 3))
    np.fill_diagonal(off, 0)
    matrix = off + np.diag(1 - off.sum(axis=1))
    return processing.InjectedColourMatrix(tuple(tuple(row) for row in matrix.tolist()))


def _demosaicing(a: float, rng: np.random.Generator) -> InjectedEffect:
    return processing.InjectedDemosaicing(str(rng.choice(["bilinear", "edge-aware"])))


def _sharpening(a: float, rng: np.random.Generator) -> InjectedEffect:
    return processing.InjectedSharpening(a, float(rng.uniform(0.7, 1.8)))


def _jpeg(a: float, rng: np.random.Generator) -> InjectedEffect:
    # amplitudes count down from quality 98
    return processing.InjectedJpeg(round(98 - a), str(rng.choice(["4:4:4", "4:2:0"])))


CATALOGUE: Mapping[str, Withheld] = {
    "exposure-error": Withheld(lambda a, r: light.InjectedExposureError(_factor(a, r)), (0.05, 0.5), 0.7),
    "conversion-gain-error": Withheld(
        lambda a, r: sensor.InjectedConversionGainError(_factor(a, r)), (0.05, 0.5), 1.0
    ),
    "vignetting": Withheld(_vignetting, (0.04, 0.69), 0.75),
    "lens-shading-correction": Withheld(
        lambda a, r: processing.InjectedShadingCorrection(0.6 * a, 0.4 * a), (0.2, 1.5), 2.0
    ),
    "illumination-gradient": Withheld(_gradient, (0.05, 0.4), 0.8),
    "veiling-glare": Withheld(lambda a, r: light.InjectedVeilingGlare(a), (0.005, 0.05), 0.3),
    "lens-distortion": Withheld(_distortion, (0.005, 0.06), 0.1),
    "focal-length-error": Withheld(_focal_length_error, (0.002, 0.03), 0.06),
    "lateral-chromatic-aberration": Withheld(_chromatic_aberration, (0.0003, 0.003), 0.015, colour=True),
    "defocus": Withheld(lambda a, r: light.InjectedDefocus(a), (0.5, 3.0), 6.0),
    "lens-blur": Withheld(_lens_blur, (0.3, 1.2), 3.0),
    "motion-blur": Withheld(_motion_blur, (1.0, 8.0), 16.0),
    "rolling-shutter": Withheld(lambda a, r: geometry.InjectedRollingShutter(a), (20.0, 80.0), 120.0),
    "flicker": Withheld(lambda a, r: light.InjectedFlicker(a, float(r.uniform(30, 200))), (0.02, 0.3), 0.6),
    "prnu": Withheld(lambda a, r: sensor.InjectedPrnu(a), (0.003, 0.015), 0.1),
    "dsnu": Withheld(_dsnu, (0.2, 2.0), 8.0),
    "defect-lines": Withheld(_defect_lines, (2.0, 30.0), 100.0, natural=False),
    "dark-current": Withheld(_dark_current, (1.0, 60.0), 400.0, natural=False),
    "crosstalk": Withheld(lambda a, r: sensor.InjectedCrosstalk(a), (0.003, 0.03), 0.08),
    "saturation": Withheld(_saturation, (0.03, 0.2), 0.35),
    "nonlinearity": Withheld(_nonlinearity, (0.01, 0.1), 0.3, natural=False),
    "read-noise": Withheld(lambda a, r: sensor.InjectedReadNoise(a), (0.5, 3.0), 8.0),
    "row-noise": Withheld(_row_noise, (0.1, 1.0), 5.0),
    "black-level": Withheld(lambda a, r: sensor.InjectedBlackLevelError(_sign(r) * a), (0.5, 6.0), 12.0),
    "quantisation": Withheld(_quantisation, (1.0, 4.0), 8.0),
    "white-balance": Withheld(_white_balance, (0.03, 0.3), 0.6, colour=True),
    "colour-matrix": Withheld(_colour_matrix, (0.05, 0.4), 0.6, colour=True),
    "demosaic": Withheld(_demosaicing, (1.0, 1.0), 1.0, colour=True),
    "denoise": Withheld(lambda a, r: processing.InjectedDenoising(a), (0.3, 2.0), 4.0),
    "sharpening": Withheld(_sharpening, (0.1, 1.0), 2.5),
    "tone-curve": Withheld(lambda a, r: processing.InjectedToneCurve(_factor(a, r)), (0.03, 0.8), 0.8),
    "jpeg": Withheld(_jpeg, (0.0, 48.0), 80.0),
    "pose-error": Withheld(_pose_error, (0.05, 0.5), 2.0),
    "conversion-gain-mode": Withheld(
        lambda a, r: sensor.InjectedConversionGainMode(math.exp(-a), 6.0), (0.2, 1.0), 1.5,
        natural=False, captures="two_gains",
    ),
}  # fmt: skip
"""All effects of the catalogue, by name."""
