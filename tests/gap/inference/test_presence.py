"""Whether an effect is there, and whether anything else is, are two questions."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_gap.evidence import Label, ReplicateResiduals
from tacos_gap.inference.presence import BY_STATISTICS, share_explained
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.unknown import doubt_beside, unexplained


class Flat:
    """Evidence of a capture: one statistic of the optics, one of the pixel."""

    def __init__(self, name: str, kind: str, seed: int, pixel: float = 0.0):
        rng = np.random.default_rng(seed)
        stages = ("optics",) * 30 + ("pixel",) * 30
        self.labels = [
            Label(name, kind, f"of the {stage}", stage, {"n": n}) for n, stage in enumerate(stages)
        ]
        self._z = rng.normal(0, 1, 60) + pixel * (np.arange(60) >= 30)
        self.null_replicates = rng.normal(0, 1, (16, 60))

    def residual(self, effects, draws=1):
        return self._z

    def replicate_residuals(self, effects):
        return ReplicateResiduals(self._z, self.null_replicates, np.ones(60))


@pytest.fixture
def problem() -> Problem:
    flats = [Flat(f"flat_{k}", "flat", k) for k in range(3)]
    return Problem([*flats, *(Flat(f"scene_{k}", "scene", 9 + k, pixel=8.0) for k in range(3))])


def test_what_is_left_is_left_in_a_stage_and_in_captures(problem):
    left = unexplained(problem, problem.replicate_residuals(()))
    assert left.score > 0.9
    assert left.by_stage["optics"] < 0.1 < 0.9 < left.by_stage["pixel"]
    assert all((p > 0.9) == name.startswith("scene") for name, p in left.by_capture.items())


def test_what_flats_prove_is_there_although_scenes_stay_unexplained(problem):
    without = problem.null + np.where(np.arange(len(problem.null)) % 60 < 30, 5.0, 0.0)
    assert BY_STATISTICS.by(share_explained(problem, problem.null, without)) == 1.0


def test_large_residuals_count_by_their_squares(problem, in_flats):
    """A rolling shutter of real frames took 197 noise floors to 56: nine tenths of the squares."""
    far_off, chosen = in_flats
    far_off.null = problem.null + 197.0 * chosen
    left = problem.null + 56.0 * chosen
    assert share_explained(far_off, left, far_off.null) == pytest.approx(1 - (56 / 197) ** 2, abs=0.01)


class Two(Flat):
    """Evidence of which one statistic was far off, and is explained; the other is off by a little."""

    def __init__(self, seed: int):
        super().__init__("flat", "flat", seed)
        self._far = 300.0 * (np.arange(60) < 30) + 5.0 * (np.arange(60) >= 30)
        self._left = self._z + 5.0 * (np.arange(60) >= 30)

    def residual(self, effects, draws=1):
        return self._z + self._far

    def replicate_residuals(self, effects):
        return ReplicateResiduals(self._left, self.null_replicates, np.ones(60))


def test_what_one_statistic_leaves_is_not_lost_beside_one_that_was_far_off():
    of = Problem([Two(3)])
    assert unexplained(of, of.replicate_residuals(())).score > 0.5


def test_what_leaves_much_where_it_shows_is_in_doubt(problem):
    in_scenes = np.array([label.kind == "scene" and label.stage == "pixel" for label in problem.labels])
    share = share_explained(problem, problem.null, problem.null + 3.0 * in_scenes)
    assert BY_STATISTICS.by(share) == 0.0  # 8 of 11 units are left


def test_an_effect_that_explains_nothing_is_shown_by_nothing(problem):
    assert share_explained(problem, problem.null, problem.null) == 0.0


def test_small_gains_where_there_is_no_gap_prove_nothing(problem):
    in_flats = np.array([label.kind == "flat" for label in problem.labels])
    noisier = problem.null * np.where(in_flats, 1.05, 1.0)
    assert share_explained(problem, problem.null, noisier) == 0.0


@pytest.fixture
def in_flats(problem):
    """Which numbers are the optics of flats, of which the null then is far off."""
    chosen = np.array([label.kind == "flat" and label.stage == "optics" for label in problem.labels])
    far_off = Problem(problem.evidence)
    far_off.null = problem.null + 15.0 * chosen
    return far_off, chosen


def test_the_rest_that_another_effect_leaves_in_a_statistic_proves_no_further_one(problem, in_flats):
    """A disc took most of the detail away, a sharpening what its form left; scenes stay unexplained."""
    far_off, chosen = in_flats
    rest = problem.null + 5.0 * chosen
    assert BY_STATISTICS.by(share_explained(far_off, problem.null, rest)) == 0.0
    assert BY_STATISTICS.by(share_explained(far_off, problem.null, far_off.null)) == 1.0


def test_two_effects_that_bend_the_same_statistic_prove_each_other_no_rest(problem, in_flats):
    """A chart through colour filters and beside an offset: each mends about half of what is wrong."""
    far_off, chosen = in_flats
    without = problem.null + 10.0 * chosen
    assert BY_STATISTICS.by(share_explained(far_off, problem.null, without)) == 1.0


def test_an_effect_that_explains_nearly_all_vouches_for_no_other(problem, in_flats):
    """Saturation took two million squares to a thousand, of which white balance left a third."""
    far_off, chosen = in_flats
    far_off.null = problem.null + 500.0 * chosen
    left, rest = (problem.null + floors * chosen for floors in (6.0, 10.0))
    in_scenes = np.array([label.kind == "scene" for label in problem.labels])
    for z in (left, rest):
        z[in_scenes] = 0.0
    assert doubt_beside(far_off, left, far_off.null) == 0.0
    assert doubt_beside(far_off, left, rest) == 1.0
    assert doubt_beside(far_off, problem.null * ~in_scenes, rest) == 0.0  # what takes the rest away is sure
