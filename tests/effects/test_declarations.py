"""What effects declare for a diagnosis: guesses that captures suggest, look-alikes, captures they show in."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from tacos_framework.contracts import LookAlike, ShownBy
from tacos_framework.plugins import Plugins
from tacos_framework.values import ImageContext, ImageGeometry
from tacos_plugins.effects.auto_exposure import AutoExposure
from tacos_plugins.effects.auto_white_balance import AutoWhiteBalance
from tacos_plugins.effects.colour_matrix import ColourMatrix
from tacos_plugins.effects.flicker import Flicker
from tacos_plugins.effects.motion_blur import MotionBlur
from tacos_plugins.effects.observations import a_series_of_exposures, one_velocity
from tacos_plugins.effects.saturation import Saturation

PLUGINS = Plugins.discover()
EFFECTS = {
    each.component.name: PLUGINS.resolve(each.component.use)
    for each in PLUGINS
    if each.component.kind == "effect" and each.distribution == "tacos-framework"
}


def seen(real, expected=None, kind="flat", **changes):
    """A capture of (N, H, W, C) files, as an effect sees it."""
    real = np.asarray(real, np.float32)
    return SimpleNamespace(
        kind=kind,
        group=changes.pop("group", None),
        real_dn=real,
        expected_dn=None if expected is None else np.asarray(expected, np.float32),
        valid=np.ones(real.shape[1:3], bool),
        context=ImageContext(**changes),
        frames=len(real),
        is_structured=kind not in ("dark", "flat", "board") and expected is not None,
        edge_angle_deg=None,
        own_edges=False,
        coding=None,
        geometry=ImageGeometry(real.shape[2], real.shape[1], 100.0, (0.0, 0.0), 3.0),
        patches=None,
    )


def test_every_look_alike_is_an_effect_and_every_need_has_a_remedy():
    declared = [each for cls in EFFECTS.values() for each in getattr(cls, "look_alikes", ())]
    assert declared
    assert all(isinstance(each, LookAlike) and each.effect in EFFECTS for each in declared)
    needs = [each for cls in EFFECTS.values() for each in getattr(cls, "shown_by", ())]
    assert all(isinstance(each, ShownBy) and each.remedy for each in needs)
    assert {name for name, cls in EFFECTS.items() if getattr(cls, "shown_by", ())} >= {"defocus", "prnu"}


@pytest.mark.parametrize("name", EFFECTS)
def test_initial_guesses_are_settings(name):
    cls = EFFECTS[name]
    for guess in getattr(cls, "initial_guesses", ()):
        cls.Config(**guess)


def test_saturation_is_guessed_where_many_pixels_share_the_top():
    rows = np.linspace(50, 250, 400)[None, :, None, None] * np.ones((1, 400, 10, 1))
    assert list(Saturation.guesses_from([seen(np.minimum(rows, 200.0))])) == [{"level_dn": 200.0}]
    assert list(Saturation.guesses_from([seen(rows**2 / 250)])) == []
    few = np.append(np.rint(np.linspace(50, 190, 40_000)), np.full(100, 200.0)).reshape(1, 401, 100, 1)
    assert list(Saturation.guesses_from([seen(few)])) == [{"level_dn": 200.0}]


def test_saturation_is_guessed_in_each_colour_where_gains_part_them():
    light = np.minimum(np.linspace(50, 250, 400), 200.0)[None, :, None, None] * np.ones((1, 400, 10, 3))
    files = np.minimum(light * np.array([0.9, 1.0, 1.4]), 255.0)
    assert list(Saturation.guesses_from([seen(files)])) == [{"level_dn": 180.0}, {"level_dn": 200.0}]


def test_flicker_is_guessed_by_the_wave_over_the_rows():
    rows = 100 * (1 + 0.1 * np.sin(2 * np.pi * np.arange(200) / 40.0))[None, :, None, None]
    lamp = seen(rows * np.ones((1, 200, 10, 1)), np.full((1, 200, 10, 1), 100.0))
    first = next(iter(Flicker.guesses_from([lamp])))
    assert first["period_rows"] == pytest.approx(40.0, rel=0.05)
    assert first["depth"] == pytest.approx(0.1, rel=0.2)


def test_a_colour_matrix_is_guessed_by_least_squares():
    matrix = np.array(((1.4, -0.3, -0.1), (-0.2, 1.3, -0.1), (0.0, -0.4, 1.4)))
    expected = np.random.default_rng(0).uniform(20, 150, (1, 40, 40, 3))
    (guess,) = ColourMatrix.guesses_from([seen(expected @ matrix.T, expected, kind="chart")])
    np.testing.assert_allclose(guess["matrix"], matrix, atol=1e-3)
    assert list(ColourMatrix.guesses_from([seen(expected[..., :1], expected[..., :1])])) == []


def test_motion_is_guessed_along_the_gradients_that_are_lost():
    expected = np.random.default_rng(0).uniform(20, 150, (1, 60, 60, 1))
    smeared = sum(np.roll(expected, shift, axis=2) for shift in range(-3, 4)) / 7
    guesses = list(MotionBlur.guesses_from([seen(smeared, expected, kind="scene")]))
    assert [guess["angle_deg"] % 180 for guess in guesses] == [0.0, 0.0]
    assert list(MotionBlur.guesses_from([seen(expected, expected, kind="scene")])) == []


def test_exposure_and_white_balance_that_settle_are_guessed_from_a_sequence():
    left = np.exp(-np.arange(6) / 2)[:, None]
    expected = np.full((6, 20, 20, 3), 100.0)
    settles = expected * np.concatenate([1.3**left, 1.0**left, 0.8**left], axis=1)[:, None, None, :]
    (guess,) = AutoWhiteBalance.guesses_from([seen(settles, expected, kind="sequence", black_level_dn=0.0)])
    assert guess["red_first"] == pytest.approx(1.3, rel=0.01)
    assert guess["blue_first"] == pytest.approx(0.8, rel=0.01)
    assert guess["lag_frames"] == pytest.approx(2.0, rel=0.07)
    brighter = expected * (1.5 ** np.arange(6))[:, None, None, None] / 8
    evened = brighter / (1.5 ** (0.6 * np.arange(6)))[:, None, None, None]
    first = next(iter(AutoExposure.guesses_from([seen(evened, brighter, kind="sequence")])))
    assert first["strength"] == pytest.approx(0.6, rel=0.01)
    assert not list(AutoExposure.guesses_from([seen(expected, expected, kind="sequence")]))
    assert not list(AutoExposure.guesses_from([seen(evened, brighter, kind="flat")]))


def test_a_series_needs_three_times_in_one_group():
    grey = np.full((1, 4, 4, 1), 100.0)
    series = [seen(grey, kind="bracket", exposure_s=t, group="a") for t in (0.01, 0.02, 0.04)]
    assert a_series_of_exposures(series)
    assert not a_series_of_exposures([*series[:2], seen(grey, kind="bracket", exposure_s=0.04, group="b")])


def test_velocities_may_be_worked_out_when_asked_for():
    grey = np.full((1, 4, 4, 1), 100.0)
    moving = [seen(grey, kind="sequence", velocity_px_s=lambda v=v: np.array([v, 0.0])) for v in (50.0, 90.0)]
    assert one_velocity(moving[:1])
    assert not one_velocity(moving)
