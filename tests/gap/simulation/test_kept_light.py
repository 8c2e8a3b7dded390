"""Light that is remembered: the same frames as without, and no more memory than allowed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.formation import EpisodeDraws
from tacos_gap.simulation.formation import simulate
from tacos_gap.simulation.kept_light import KeptLight
from tacos_plugins.effects.blur import blur, gaussian_kernel, gaussian_transfer, kernel_of
from tacos_plugins.effects.lens_distortion import LensDistortion
from tests.gap.small_captures import capture, placed, squares


def _frame(value: float) -> np.ndarray:
    return np.full((1, 4, 4, 1), value, np.float32)


def test_what_is_known_is_not_made_again():
    light, made = KeptLight(1 << 20), []

    def make() -> np.ndarray:
        made.append(1)
        return _frame(1.0)

    first, second = (light.after(["vignetting"], make) for _ in range(2))
    assert first is second
    assert len(made) == 1


def test_that_chance_acts_is_remembered():
    light, made = KeptLight(0), []
    for _ in range(2):
        assert light.after(["prnu"], lambda: made.append(1)) is None
    assert len(made) == 1


def test_the_oldest_goes_where_room_ends():
    light = KeptLight(2 * _frame(0).nbytes)
    for name in ("a", "b", "a", "c"):
        light.after([name], lambda: _frame(0.0))
    assert light.after(["a"], lambda: _frame(9.0))[0, 0, 0, 0] == 0.0
    assert light.after(["b"], lambda: _frame(9.0))[0, 0, 0, 0] == 9.0


@pytest.mark.parametrize("sigma_px", [0.3, 1.3, 4.0])
def test_a_gaussian_along_both_axes_in_turn_is_the_kernel_of_both(sigma_px):
    along = gaussian_kernel(sigma_px)
    square = kernel_of(gaussian_transfer(sigma_px), reach_px=4 * sigma_px)
    assert np.abs(np.outer(along, along) - square).max() < 1e-12
    frames = np.random.default_rng(0).uniform(0, 255, (1, 40, 50, 3)).astype(np.float32)
    assert np.abs(blur(frames, along) - blur(frames, square)).max() < 1e-3


def test_edges_read_off_the_pictures_lie_where_the_lens_has_put_them():
    """A lens moves what is expected of a world, and not what was seen through it."""
    expected = capture("edge", "edge", squares())
    lens = placed("lens-distortion", LensDistortion, k1=-0.2)
    draws = EpisodeDraws(0, ("edge",))
    seen = replace(expected, own_edges=True)
    assert np.array_equal(simulate(seen, [lens], draws), simulate(seen, [], draws))
    assert not np.array_equal(simulate(expected, [lens], draws), simulate(expected, [], draws))
