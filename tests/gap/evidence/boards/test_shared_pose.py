"""What moves all captures alike is an effect; what moves each by itself is a nuisance of each."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.camera.resampling import composed, resample
from tacos_framework.formation import EpisodeDraws
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.nuisances import POSE_TERMS, Freedom, disturbed, shares_of_priors
from tacos_gap.simulation.formation import simulate
from tacos_gap.statistics import Sample, displacement, measure
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture, effects_named, placed
from tests.gap.taken import patchwork

FREEDOMS = [Freedom(name, 1.0) for name in POSE_TERMS]
X, Y = np.meshgrid(np.arange(float(WIDTH)), np.arange(float(HEIGHT)))


@pytest.fixture(scope="module")
def effects() -> dict[str, type[Any]]:
    return effects_named("focal-length-error", "pose-error", "lens-distortion", "defocus")


def scenes() -> list[RealCapture]:
    image = patchwork() + BLACK_DN
    sides = (image, image[::-1, ::-1], image[:, ::-1], image[::-1])
    return [capture(f"scene_{k}", "scene", side, frames=2) for k, side in enumerate(sides)]


def poses(values: np.ndarray) -> list[dict[str, float]]:
    return [dict(zip(POSE_TERMS, row, strict=True)) for row in values.tolist()]


# how far captures disagree --------------------------------------------------------------------------------


@given(st.integers(0, 100), st.lists(st.floats(-5, 5), min_size=6, max_size=6))
@settings(max_examples=30, deadline=None)
def test_what_captures_share_narrows_no_prior(seed, shared):
    own = np.random.default_rng(seed).normal(size=(5, 6)) * 0.1
    groups = ["a", "b", "c", "d", "e"]
    alone, beside = (shares_of_priors(poses(own + offset), groups) for offset in (0, np.array(shared)))
    assert beside == pytest.approx(alone)


@pytest.mark.parametrize("count", [2, 3, 6])
def test_captures_that_scatter_as_their_priors_say_seldom_narrow_them(count):
    rng = np.random.default_rng(count)
    groups = [str(k) for k in range(count)]
    narrowed = [bool(shares_of_priors(poses(rng.normal(size=(count, 6))), groups)) for _ in range(400)]
    assert np.mean(narrowed) < 0.08


def test_true_scatter_is_within_what_is_said_nineteen_times_in_twenty():
    rng = np.random.default_rng(1)
    sigma = 0.2
    said = [
        shares_of_priors(poses(sigma * rng.normal(size=(6, 6))), list("abcdef")).get("rotation_deg", 1.0)
        for _ in range(1000)
    ]
    assert np.mean(np.array(said) >= sigma) == pytest.approx(0.95, abs=0.025)


def test_captures_set_up_together_count_once():
    alike = poses(np.full((4, 6), 0.4))
    assert shares_of_priors(alike, ["series"] * 4) == {}
    assert set(shares_of_priors(alike, list("abcd"))) == set(POSE_TERMS)


# one kernel, read once ------------------------------------------------------------------------------------


def test_an_effect_that_undoes_a_nuisance_leaves_the_very_picture(effects):
    """What is moved at once keeps its detail: moved one after another, edges would be off by many codes."""
    still = scenes()[0]
    nuisance = disturbed(still, FREEDOMS, np.array([0.5, -0.3, 0.0, 0.0, 0.0, 0.0]))
    undone = [placed("focal-length-error", effects["focal-length-error"], dx_px=-0.5, dy_px=0.3)]
    draws = EpisodeDraws(1, ("same",))
    inside = (slice(None), slice(2, -2), slice(2, -2))
    back, plain = simulate(nuisance, undone, draws), simulate(still, [], draws)
    np.testing.assert_array_equal(back[inside], plain[inside])


def test_effects_and_nuisances_move_alike(effects):
    still = scenes()[0]
    nuisance = disturbed(still, FREEDOMS, np.array([0.31, -0.17, 0.0, 0.01, 0.0, 0.0]))
    effect = placed("focal-length-error", effects["focal-length-error"], dx_px=0.31, dy_px=-0.17, scale=1.01)
    draws = EpisodeDraws(1, ("same",))
    difference = simulate(nuisance, [], draws) - simulate(still, [effect], draws)
    assert np.mean(difference != 0) < 0.001  # some stand between two codes


def test_moves_are_composed_as_pictures_are_moved_one_after_another():
    """Of a smooth picture, for which reading it twice costs nothing."""
    smooth = (100 + 50 * np.sin(0.1 * X + 0.07 * Y))[None, ..., None]
    first = X + 0.4 + 0.01 * (Y - 60), Y - 0.3 + 2e-4 * (X - 80) ** 2
    then = 1.01 * X - 1.2, 0.99 * Y + 0.6
    twice = resample(resample(smooth, *first), *then)
    once = resample(smooth, *composed(first, then))
    np.testing.assert_allclose(once[:, 12:-12, 12:-12], twice[:, 12:-12, 12:-12], atol=0.02)


# displacements --------------------------------------------------------------------------------------------


def displacements(still: RealCapture, dx_px: float) -> np.ndarray:
    assert still.expected_dn is not None
    frames = resample(still.expected_dn, X - dx_px, Y)
    found = [b for b in measure(Sample(still, frames, still.expected_dn)) if b.statistic == "displacement"]
    return np.asarray(found[0].values)


def test_displacements_follow_shifts_of_hundredths_of_a_pixel():
    """Dense flow jumps: its differences over such a shift are 60 % off."""
    still = scenes()[0]
    here = displacements(still, 0.0)
    np.testing.assert_allclose(here, 0, atol=1e-3)
    for dx in (0.01, 0.05, 0.3):
        assert np.median(displacements(still, dx)) == pytest.approx(dx, rel=0.06)
        slopes = (displacements(still, dx + 0.01) - displacements(still, dx)) / 0.01
        assert np.quantile(np.abs(slopes - 1), 0.8) < 0.25


def test_displacements_mind_no_gain_and_no_pedestal():
    still = scenes()[0]
    assert still.expected_dn is not None
    frames = 0.7 * resample(still.expected_dn, X - 0.4, Y) + 12
    found = [b for b in measure(Sample(still, frames, still.expected_dn)) if b.statistic == "displacement"]
    np.testing.assert_allclose(found[0].values, displacements(still, 0.4), atol=0.02)


@pytest.mark.parametrize(("dx_px", "is_looked_for"), [(0.0, False), (0.3, False), (0.7, True), (3.0, True)])
def test_flow_is_looked_for_past_half_a_pixel(monkeypatch, dx_px, is_looked_for):
    calls = []
    flow = displacement.dense_flow
    monkeypatch.setattr(displacement, "dense_flow", lambda *given: calls.append(given) or flow(*given))
    assert np.median(displacements(scenes()[0], dx_px)) == pytest.approx(dx_px, abs=0.05)
    assert bool(calls) == is_looked_for


# the diagnosis --------------------------------------------------------------------------------------------


def diagnosed(real: list[RealCapture], effects: dict[str, type[Any]], seed: int) -> Any:
    from pathlib import Path

    return diagnose(CaptureFolder(Path("captures"), tuple(real)), effects, seed=seed, workers=1)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_shift_that_all_captures_share_is_found_within_its_interval(effects, seed):
    true = {"scale": 1.003, "dx_px": 0.3, "dy_px": -0.2}
    shifted = placed("focal-length-error", effects["focal-length-error"], **true)
    real = [
        replace(each, real_dn=simulate(each, [shifted], EpisodeDraws(seed, ("taken", i))))
        for i, each in enumerate(scenes())
    ]
    found = diagnosed(real, {"focal-length-error": effects["focal-length-error"]}, seed)
    parameters = found.causes[0].parameters
    for name, value in true.items():
        low, high = parameters[name].interval
        half = (high - low) / 2
        assert abs(parameters[name].value - value) < 2 * half
        assert half < 0.05


def test_shifts_of_each_capture_are_nobodys_error(effects):
    own = np.array([[0.3, -0.2], [-0.35, 0.1], [0.1, 0.4], [-0.2, -0.3]])
    real = []
    for i, (each, (dx, dy)) in enumerate(zip(scenes(), own, strict=True)):
        moved = disturbed(each, FREEDOMS, np.array([dx, dy, 0, 0, 0, 0]))
        real.append(replace(each, real_dn=simulate(moved, [], EpisodeDraws(4, ("taken", i)))))
    found = diagnosed(real, effects, seed=0)
    assert found.verdict == "no_gap"
    shifts = [found.nuisances[f"scene_{k}"]["shift_px"] for k in range(4)]
    np.testing.assert_allclose(shifts, own, atol=0.05)
