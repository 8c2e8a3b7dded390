"""Settings that a camera sets anew for each capture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.signal import fftconvolve
from skimage.morphology import disk
from skimage.transform import downscale_local_mean

from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.hypotheses.parameters import HypothesisTerm, initial_guesses_for
from tacos_plugins.effects.defocus import Defocus
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture, effects_named

_FINE = 8


@pytest.fixture(scope="module")
def effects() -> dict[str, type[Any]]:
    return effects_named("defocus", "lens-blur", "exposure-error")


def texture(seed: int) -> np.ndarray:
    """(8 H, 8 W) patches of many sizes, eight samples to a pixel [DN above black]."""
    rng = np.random.default_rng(seed)
    shape = (HEIGHT * _FINE // 2, WIDTH * _FINE // 2)
    noises = [gaussian_filter(rng.standard_normal(shape), sigma) for sigma in (8, 24)]
    patches = np.sum([np.sign(noise) for noise in noises], axis=0)
    return np.asarray((95 + 30 * patches).repeat(2, 0).repeat(2, 1))


def blurred(name: str, radius_px: float, seed: int) -> RealCapture:
    """A scene blurred by a disc that eight samples to a pixel resolve, with the noise that is stated."""
    sharp = texture(seed)
    disc = disk(round(radius_px * _FINE)).astype(float)
    seen = fftconvolve(np.pad(sharp, 64, mode="reflect"), disc / disc.sum(), "same")[64:-64, 64:-64]
    expected, real = (downscale_local_mean(image, (_FINE, _FINE)) for image in (sharp, seen))
    scene = capture(name, "scene", BLACK_DN + expected)
    rng = np.random.default_rng(seed + 100)
    noisy = BLACK_DN + real + rng.standard_normal((2, HEIGHT, WIDTH)) * np.sqrt(1.8 + 0.24 * real)
    return replace(scene, real_dn=np.clip(np.round(noisy), 0, 255).astype(np.float32)[..., None])


def diagnosed(captures: list[RealCapture], effects: dict[str, type[Any]]) -> Diagnosis:
    return diagnose(CaptureFolder(Path("captures"), tuple(captures)), effects, seed=3)


def test_each_picture_has_the_focus_it_was_taken_with(effects):
    radii = {"near": 1.0, "middle": 3.0, "far": 5.0}
    found = diagnosed([blurred(name, r, i) for i, (name, r) in enumerate(radii.items())], effects)
    first = found.causes[0]
    assert first.effect == "defocus"
    assert first.present > 0.5
    radius = first.parameters["radius_px"]
    for name, true in radii.items():
        # the blur that each capture may have, 0.03 px^2, is an eighth of that of a disc of 1 px
        assert radius.by_capture[name].value == pytest.approx(true, rel=0.1, abs=0.15)
    assert radius.value == pytest.approx(3.0, rel=0.1)
    assert first.settings["radius_px"] == pytest.approx(radius.value)
    assert any("set it anew for each capture" in text for text in found.limitations)
    data = found.as_data()["causes"][0]["parameters"]["radius_px"]
    assert set(data["by_capture"]) == set(radii)


def test_one_focus_for_all_pictures_is_one_value(effects):
    found = diagnosed([blurred(f"view_{i}", 2.0, i) for i in range(3)], effects)
    first = found.causes[0]
    assert first.effect == "defocus"
    radius = first.parameters["radius_px"]
    assert not radius.by_capture
    assert radius.value == pytest.approx(2.0, rel=0.1)


def test_guesses_by_capture_need_several_that_show_the_effect():
    views = [blurred(f"view_{i}", r, i) for i, r in enumerate((1.5, 4.0))]
    flat = capture("flat", "flat", 100.0)
    (own,) = [t for t in initial_guesses_for("defocus", Defocus, [*views, flat]) if len(t.free) > 1]
    assert own.values == pytest.approx({"radius_px@view_0": 1.5, "radius_px@view_1": 4.0}, rel=0.15)
    assert all(len(t.free) == 1 for t in initial_guesses_for("defocus", Defocus, [views[0], flat]))


def test_a_value_of_one_capture_acts_there_alone():
    term = HypothesisTerm("defocus", Defocus, {"radius_px@a": 1.0, "radius_px@b": 4.0}, {})
    placed = {name: term.placed(name) for name in ("a", "b", "elsewhere")}
    assert [effect.config.radius_px for effect in placed.values() if effect] == [1.0, 4.0, 2.5]
    assert replace(term, values={"radius_px@a": 1.0, "radius_px@b": -1.0}).placed("a") is None
