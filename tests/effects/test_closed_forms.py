"""What arithmetic tells of a camera of numpy's own, with errors that hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
import pytest

from tacos_framework.contracts.observed import Estimate
from tacos_gap.captures import RealCapture
from tacos_plugins.effects import closed_forms
from tacos_plugins.effects.crosstalk import Crosstalk
from tacos_plugins.effects.denoise import Denoise
from tacos_plugins.effects.dsnu import Dsnu
from tacos_plugins.effects.edge_spread import are_sharpened, edge_variances_px2
from tacos_plugins.effects.lens_blur import LensBlur
from tacos_plugins.effects.prnu import Prnu
from tacos_plugins.effects.row_noise import RowNoise
from tacos_plugins.effects.sharpening import Sharpening
from tacos_plugins.effects.vignetting import Vignetting
from tests.gap.taken import BLACK_DN, HEIGHT, WIDTH, capture

FULL_E = 6000.0


class Camera:
    """Shot noise of electrons, a pattern, fall-off, rows that jump, blur; whole numbers."""

    def __init__(self, seed: int, **wrong: float):
        self.rng = np.random.default_rng(seed)
        self.wrong = wrong
        self.response = 1 + wrong.get("prnu", 0.0) * self.rng.standard_normal((HEIGHT, WIDTH))
        self.offsets = wrong.get("columns", 0.0) * self.rng.standard_normal((1, WIDTH))

    def frame(self, level_dn: np.ndarray | float) -> np.ndarray:
        wrong, shape = self.wrong, (HEIGHT, WIDTH)
        light = np.broadcast_to(np.asarray(level_dn, float), shape)
        if sigma := wrong.get("blur"):
            light = cv2.GaussianBlur(light, (0, 0), sigma)
        y, x = np.mgrid[:HEIGHT, :WIDTH]
        r2 = ((x - (WIDTH - 1) / 2) ** 2 + (y - (HEIGHT - 1) / 2) ** 2) / (WIDTH**2 / 4 + HEIGHT**2 / 4)
        electrons = light / 255 * FULL_E * (1 + wrong.get("k1", 0.0) * r2) * self.response
        noisy = self.rng.poisson(np.maximum(electrons, 0)) + self.rng.normal(0, 20, shape)
        dn = noisy * 255 / FULL_E + BLACK_DN + self.offsets
        dn = dn + wrong.get("rows", 0.0) * self.rng.standard_normal((HEIGHT, 1))
        if share := wrong.get("share"):
            kernel = np.full((3, 3), share)
            kernel[::2, ::2] *= wrong.get("corners", 1.0)
            kernel[1, 1] += 1 - kernel.sum()
            dn = cv2.filter2D(dn, -1, kernel)
        return np.asarray(np.clip(np.rint(dn), 0, 255), np.float32)

    def taken(self, kind: str, level: np.ndarray | float, frames: int = 4) -> RealCapture:
        real = np.stack([self.frame(level) for _ in range(frames)])[..., None]
        return replace(capture(kind, level, frames=frames), real_dn=real)

    def folder(self) -> list[RealCapture]:
        return [self.taken("dark", 0.0), *(self.taken("flat", level) for level in (60.0, 120.0, 180.0))]


def told(cls: type, camera: Camera) -> dict[str, Estimate]:
    found: Iterator[Estimate] = cls.estimate_from(camera.folder())  # type: ignore[attr-defined]
    return {each.parameter: each for each in found}


@pytest.mark.parametrize(
    ("cls", "wrong", "parameter", "value"),
    [
        (RowNoise, {"rows": 0.4}, "sigma_dn", 0.4),
        (Dsnu, {"columns": 0.5}, "column_sigma_dn", 0.5),
        (Prnu, {"prnu": 0.009}, "sigma", 0.009),
        (Vignetting, {"k1": -0.3}, "k1", -0.3),
        (Crosstalk, {"share": 0.015}, "share", 0.015),
    ],
)
def test_what_is_there_is_seen_within_its_error_and_else_it_is_not(cls, wrong, parameter, value):
    name = next(iter(wrong))
    seen = told(cls, Camera(1, **wrong))[parameter]
    assert seen.is_seen(0.0)
    assert seen.value == pytest.approx(value, abs=4 * seen.standard_error + 0.03 * abs(value))
    absent = told(cls, Camera(2))
    assert not any(each.is_seen(0.0) for each in absent.values()), name


def test_defect_columns_are_no_pattern_of_all_columns():
    camera = Camera(5)
    camera.offsets = np.zeros((1, WIDTH))
    camera.offsets[0, [20, 70, 130]] = 3.0
    assert not told(Dsnu, camera)["column_sigma_dn"].is_seen(0.0)


def test_rows_that_jump_are_no_crosstalk():
    assert not any(each.is_seen(0.0) for each in told(Crosstalk, Camera(6, rows=2.0)).values())


def test_noise_of_faint_walls_smoothed_more_is_no_crosstalk():
    camera = Camera(7)
    walls = []
    for share, level in ((0.045, 60.0), (0.02, 120.0), (0.005, 180.0)):
        camera.wrong = {"share": share}
        walls.append(camera.taken("flat", level))
    assert not any(each.is_seen(0.0) for each in Crosstalk.estimate_from(walls))


def test_white_walls_exclude_denoising_unless_darks_may_be_smoothed():
    camera = Camera(8)
    walls = [camera.taken("flat", level, frames=2) for level in np.linspace(60, 180, 60)]
    found = {each.parameter: each for each in Denoise.estimate_from([camera.taken("dark", 0.0), *walls])}
    assert found["strength"].is_excluded(0.0)
    assert not found["threshold"].is_excluded(0.0)
    assert not found["threshold"].is_seen(0.0)
    assert [each.parameter for each in Denoise.estimate_from(walls)] == ["strength"]


@pytest.mark.parametrize("corners", [0.0, 0.5, 1.0])
def test_noise_tells_whether_neighbours_at_corners_share(corners):
    found = told(Crosstalk, Camera(4, share=0.03, corners=corners))
    assert found["share"].value == pytest.approx(0.03, rel=0.1)  # rounding adds white noise
    assert found["corners"].value == pytest.approx(corners, abs=0.1)
    assert found["corners"].is_seen(1.0) == (corners < 1)


def test_errors_of_a_pattern_hold_about_as_often_as_they_say():
    """Of the variance, which is what is measured."""
    misses = []
    for seed in range(20):
        walls = [Camera(seed, prnu=0.006).taken("flat", 150.0, frames=2)]
        found = closed_forms.pattern_variance(walls, relative=True)
        assert found is not None
        misses.append((found.value - 0.006**2) / found.standard_error)
    assert 0.5 < np.std(misses) < 2.0
    assert abs(np.mean(misses)) < 1.0


def test_an_effect_is_excluded_only_with_power():
    many = Estimate("sigma", 0.0001, 0.0002, negligible=0.001)
    few = Estimate("sigma", 0.0001, 0.002, negligible=0.001)
    assert many.is_excluded(0.0)
    assert not few.is_excluded(0.0)
    assert not few.is_seen(0.0)


def test_sharpened_noise_is_not_white_and_excludes_no_sharpening():
    flat = Camera(3).taken("flat", 120.0, frames=6)
    sharp = flat.real_dn + 0.5 * (
        flat.real_dn - np.stack([cv2.blur(f, (3, 3))[..., None] for f in flat.real_dn])
    )
    assert list(Sharpening.estimate_from([replace(flat, real_dn=sharp)])) == []


def test_darks_cut_off_at_0_tell_no_pedestal_and_no_rows():
    dark = Camera(4).taken("dark", 0.0)
    cut = replace(dark, real_dn=np.maximum(dark.real_dn - BLACK_DN, 0))
    assert closed_forms.pedestal_off_dn([cut]) is None
    assert list(RowNoise.estimate_from([cut])) == []


@pytest.mark.parametrize("sigma_px", [0.7, 1.3, 2.0])
@pytest.mark.parametrize("turned", [False, True])
def test_the_spread_of_an_edge_is_that_of_the_blur(sigma_px, turned):
    fine = 8
    y, x = np.mgrid[: HEIGHT * fine, : WIDTH * fine] / fine
    across = (y - HEIGHT / 2 - 0.1 * (x - WIDTH / 2)) if turned else (x - WIDTH / 2 - 0.1 * (y - HEIGHT / 2))
    ideal = cv2.resize(np.where(across > 0, 160.0, 30.0), (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    edge = replace(Camera(5, blur=sigma_px, k1=-0.2).taken("edge", ideal), edge_angle_deg=5.7)
    assert np.mean(edge_variances_px2(edge)) ** 0.5 == pytest.approx(sigma_px, rel=0.08)
    (found,) = LensBlur.estimate_from([edge])
    assert found.is_seen(0.0)


def test_the_width_of_a_sharpened_edge_excludes_no_blur():
    """Sharpening takes the second moment away that a blur added: nothing is left, and nothing is told."""
    ideal = np.where(np.mgrid[:HEIGHT, :WIDTH][1] > WIDTH / 2, 160.0, 30.0)
    slanted = cv2.warpAffine(
        ideal,
        np.array([[1, 0.1, -0.05 * HEIGHT], [0, 1, 0.0]]),
        (WIDTH, HEIGHT),
        borderMode=cv2.BORDER_REPLICATE,
    )
    blurred = replace(Camera(5, blur=0.9).taken("edge", slanted), edge_angle_deg=5.7)
    sharp = np.stack(
        [f[..., 0] + 1.2 * (f[..., 0] - cv2.GaussianBlur(f[..., 0], (0, 0), 1.3)) for f in blurred.real_dn]
    )
    sharpened = replace(blurred, real_dn=sharp[..., None])
    assert edge_variances_px2(blurred)
    assert list(LensBlur.estimate_from([sharpened])) == []
    assert are_sharpened([sharpened])
    assert not are_sharpened([blurred])
