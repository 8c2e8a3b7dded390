"""What was found at one camera holds for another: pitch, gain, exposure and binning are counted in.

An effect is found at one camera, in its pixels and digital numbers, and turned into physical units. At two
other cameras it then acts on binned images. The truth is a simulation of every photosite of these cameras,
the effect in their pixels and digital numbers by arithmetic written out here, averaged over blocks
afterwards. Contrast is the height of a sine over its mean, of light in bars of a sine.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tacos_framework.plugins import Plugins
from tacos_framework.settings import averaging_of, unit_of
from tacos_gap.answer.physical_settings import physical_settings_of
from tests.effects.cameras import CAMERAS, CAPTURED, Pattern, Setup, bars, even, placed_at, wave

BARS_PX = 8
"""From bar to bar, in binned pixels."""
Figures = Callable[[NDArray[Any], int], list[float]]
"""Numbers that say what an effect did, from (N, H, W) images in e- of a camera of some binning."""


def contrast(images: NDArray[Any], binning: int) -> list[float]:
    return [abs(wave(images, BARS_PX))]


def columns(images: NDArray[Any], binning: int) -> list[float]:
    """Where the bars are, to the right [px]."""
    return [-np.angle(wave(images, BARS_PX) * 1j) / (2 * np.pi) * BARS_PX]


def rows(images: NDArray[Any], binning: int) -> list[float]:
    return [-np.angle(wave(images, BARS_PX, axis=1) * 1j) / (2 * np.pi) * BARS_PX]


def level(images: NDArray[Any], binning: int) -> list[float]:
    return [images.mean()]


def temporal_variance(images: NDArray[Any], binning: int) -> list[float]:
    return [images.var(axis=0, ddof=1).mean()]


def spatial_variance(images: NDArray[Any], binning: int) -> list[float]:
    mean = images.mean(axis=0)
    return [mean.var()]


def row_variance(images: NDArray[Any], binning: int) -> list[float]:
    return [images.mean(axis=2).var(axis=0, ddof=1).mean()]


def column_variance(images: NDArray[Any], binning: int) -> list[float]:
    return [images.mean(axis=1).var(axis=0, ddof=1).mean()]


def fixed_column_variance(images: NDArray[Any], binning: int) -> list[float]:
    return [images.mean(axis=(0, 1)).var()]


def level_and_spatial_variance(images: NDArray[Any], binning: int) -> list[float]:
    return [images.mean(), images.mean(axis=0).var()]


def neighbours(images: NDArray[Any], binning: int) -> list[float]:
    """Covariance of the noise of neighbours over its variance."""
    noise = images - images.mean(axis=0)
    return [(noise[:, :, 1:] * noise[:, :, :-1]).mean() / noise.var()]


def row_wave(images: NDArray[Any], binning: int) -> list[float]:
    """Height of the wave over the rows with a period of 48 photosites."""
    return [np.mean([abs(wave(image[None], 48 / binning, axis=1)) for image in images])]


@dataclass(frozen=True)
class Case:
    """An effect's parameter as found at `CAPTURED`, and what tells it."""

    value: float
    """In pixels or digital numbers of the captured camera's photosites."""
    figures: Figures
    """What it changes."""
    settings: dict[str, Any] = field(default_factory=dict)
    """Of the effect, besides."""
    in_bars: bool = False
    """Whether the light is in bars, rather than even."""
    electrons: float = 2000.0
    """Signal of the light [e-]."""
    noise_dn: float | None = None
    """In place of them, so much light that its noise is this [DN]."""
    frames: int = 1
    size: tuple[int, int] = (240, 240)
    excess: bool = True
    """Whether figures count beyond those without the effect, as variances do."""


K = CAPTURED.context.dn_per_electron
NOISE = {"electrons": 200.0, "frames": 30}
CASES: dict[tuple[str, str], Case] = {
    ("defocus", "radius_px"): Case(6.0, contrast, in_bars=True, excess=False),
    ("lens-blur", "sigma_px"): Case(3.0, contrast, in_bars=True, excess=False),
    ("motion-blur", "length_px"): Case(9.0, contrast, in_bars=True, excess=False),
    ("focal-length-error", "dx_px"): Case(5.0, columns, in_bars=True),
    ("focal-length-error", "dy_px"): Case(-5.0, rows, in_bars=True),
    ("sharpening", "radius_px"): Case(3.0, contrast, {"amount": 2.0}, in_bars=True, excess=False),
    ("flicker", "period_rows"): Case(48.0, row_wave, {"depth": 0.4}, frames=4, excess=False),
    ("read-noise", "sigma_dn"): Case(30 * K, temporal_variance, **NOISE),
    ("read-noise", "after_gain_dn"): Case(400.0, temporal_variance, **NOISE),
    ("row-noise", "sigma_dn"): Case(8 * K, row_variance, size=(240, 48), electrons=100.0, frames=150),
    ("row-noise", "column_sigma_dn"): Case(
        8 * K, column_variance, size=(48, 240), electrons=100.0, frames=150
    ),
    ("dsnu", "sigma_dn"): Case(30 * K, spatial_variance, **NOISE),
    ("dsnu", "column_sigma_dn"): Case(
        8 * K, fixed_column_variance, size=(24, 36_000), electrons=50.0, frames=3
    ),
    ("prnu", "sigma"): Case(0.05, spatial_variance, frames=20),
    ("dark-current", "rate_dn_s"): Case(40_000 * K, level, electrons=500.0),
    ("dark-current", "nonuniformity"): Case(
        0.6, level_and_spatial_variance, {"rate_e_s": 15_000.0}, electrons=30.0, frames=4, size=(480, 480)
    ),
    ("dark-current", "hot_rate_dn_s"): Case(
        15_000 * K, level_and_spatial_variance, {"hot_share": 0.05}, electrons=30.0, frames=2, size=(960, 960)
    ),
    ("defect-lines", "offset_dn"): Case(800 * K, level, {"column_share": 0.1}, electrons=100.0, frames=3),
    ("saturation", "level_dn"): Case(2000.0 + 2500 * K, level, electrons=3500.0, excess=False),
    ("black-level", "offset_dn"): Case(600.0, level, electrons=100.0),
    ("quantisation", "step_dn"): Case(512.0, temporal_variance, noise_dn=350.0, frames=60),
    ("crosstalk", "share"): Case(0.03, neighbours, frames=30),
}
"""Every parameter that counts pixels, rows or digital numbers, or a spread of photosites."""
WHOLE_FILE = {("quantisation", "step_dn"), ("black-level", "offset_dn"), ("read-noise", "after_gain_dn")}
"""Those that belong to the codes of the file."""
SHIPPED = [each.component for each in Plugins.discover() if each.distribution == "tacos-framework"]
EFFECTS = {c.name: c.load() for c in SHIPPED if c.kind == "effect"}


def at_photosites(name: tuple[str, str], value: float, setup: Setup) -> float:
    """The value found at the captured camera, in photosites and digital numbers of another."""
    there, here = CAPTURED.context, setup.context
    gain = here.dn_per_electron / there.dn_per_electron
    match name:
        case ("motion-blur", "length_px"):
            time = here.exposure_s / there.exposure_s
            return value * time * CAPTURED.pixel_um / setup.pixel_um
        case ("saturation", "level_dn"):
            return here.black_level_dn + (value - there.black_level_dn) * gain
        case ("sharpening" | "flicker" | "prnu" | "crosstalk", _) | (_, "nonuniformity"):
            return value
        case _ if name in WHOLE_FILE:
            return value * (here.white_level_dn + 1) / (there.white_level_dn + 1)
        case (_, setting) if setting.endswith("_px"):
            return value * CAPTURED.pixel_um / setup.pixel_um
    return value * gain


def transferred(name: tuple[str, str], case: Case) -> dict[str, Any]:
    """What a recipe for other cameras says: in physical units where there are any."""
    kind = EFFECTS[name[0]].Config
    found = {**case.settings, name[1]: case.value}
    physical = physical_settings_of(kind, found, CAPTURED.geometry, CAPTURED.context)
    return {**{key: value for key, value in found.items() if key not in physical}, **dict(physical.values())}


def test_no_parameter_that_depends_on_the_camera_is_left_out() -> None:
    counted = {
        (name, setting)
        for name, cls in EFFECTS.items()
        for setting in cls.Config.model_fields
        if unit_of(cls.Config, setting) in ("px", "row", "DN", "DN/s") or averaging_of(cls.Config, setting)
    }
    counted -= {("lens", "infinity_px")}  # no diagnosis finds it; `test_lens` has it at two binnings
    assert counted | {("crosstalk", "share")} == set(CASES)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("name", CASES, ids=" ".join)
def test_an_effect_found_at_one_camera_is_the_same_at_another(name: tuple[str, str], camera: str) -> None:
    case, setup, cls = CASES[name], CAMERAS[camera], EFFECTS[name[0]]
    pattern: Pattern = bars(BARS_PX * setup.binning) if case.in_bars else even
    electrons = case.electrons
    if case.noise_dn is not None:
        electrons = (case.noise_dn / setup.context.dn_per_electron) ** 2
    taking = {"electrons": electrons, "frames": case.frames, "size": case.size}
    known = placed_at(cls, transferred(name, case))
    truth = placed_at(cls, {**case.settings, name[1]: at_photosites(name, case.value, setup)})

    def figures(effect: Any, full: bool) -> NDArray[np.float64]:
        images = setup.images(pattern, [effect] if effect else [], full=full, **taking)
        return np.array(case.figures(images, setup.binning))

    found, expected = figures(known, full=False), figures(truth, full=True)
    without = figures(None, full=False)
    assert np.all(np.abs(expected - without) > 0.1 * np.abs(without)), "too weak to be seen"
    if case.excess:
        found, expected = found - without, expected - figures(None, full=True)
    np.testing.assert_allclose(found, expected, rtol=0.05)


@pytest.mark.parametrize(("binning", "loss"), [(4, 0.07), (16, 0.005)])
def test_defocus_of_a_fine_pixel_hardly_matters_to_a_binned_one(binning: int, loss: float) -> None:
    """Bars of 2.5 binned pixels; taken for pixels of the image, 1.2 px cost two thirds of it.

    Taps that are never negative, with the variance of the disc, leave at most 3 % more of such fine bars.
    """
    setup, defocus = CAMERAS["finer, 6 dB, 4 x 4"], EFFECTS["defocus"]
    taking = {"electrons": 2000.0, "binning": binning, "size": (40 * binning, 160 * binning)}

    def seen(radius_px: float, full: bool = False) -> float:
        effects = [placed_at(defocus, {"radius_px": radius_px})]
        return abs(wave(setup.images(bars(2.5 * binning), effects, full=full, **taking), 2.5))

    assert 1 - seen(1.2) / seen(0.0) == pytest.approx(loss, abs=0.03)
    assert 1 - seen(1.2, full=True) / seen(0.0, full=True) == pytest.approx(loss, abs=0.006)
    assert 1 - seen(1.2 * binning) / seen(0.0) > 0.6
