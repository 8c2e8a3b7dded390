"""Where a gap lies: what is significant is found, what is not is not."""

from __future__ import annotations

import numpy as np

from tacos_gap.evidence import Label, ReplicateResiduals
from tacos_gap.inference.location import locate
from tacos_gap.inference.problem import Problem
from tacos_gap.inference.unknown import unexplained

STATISTICS = [f"statistic {k}" for k in range(20)]
NUMBERS = 12


class Blocks:
    """Twenty statistics of noise 1; to the named ones something is added."""

    def __init__(self, seed: int, **added: float):
        rng = np.random.default_rng(seed)
        places = [(name, k) for name in STATISTICS for k in range(NUMBERS)]
        self.labels = [Label("flat", "flat", name, "pixel", {"bin": k}) for name, k in places]
        self._z = rng.normal(0, 1, len(places))
        for key, size in added.items():
            at = int(key.removeprefix("at_"))
            self._z[at * NUMBERS : (at + 1) * NUMBERS] += size
        self.null_replicates = rng.normal(0, 1, (16, len(places)))

    def residual(self, effects, draws=1):
        return self._z

    def replicate_residuals(self, effects):
        return ReplicateResiduals(self._z, self.null_replicates, np.ones_like(self._z))


def test_the_statistic_that_differs_comes_first_with_its_place():
    of = Problem([Blocks(1, at_7=6.0, at_3=3.0)])
    found = locate(of, of.null)
    assert [place.statistic for place in found] == ["statistic 7", "statistic 3"]
    assert found[0].share > found[1].share
    assert found[0].captures == ("flat",)
    assert found[0].z > 6


def test_noise_is_seldom_a_place():
    found = [len(locate(of, of.null)) for of in (Problem([Blocks(seed)]) for seed in range(40))]
    assert np.mean(np.array(found) > 0) <= 0.1


def test_nothing_left_is_nothing_unknown():
    of = [Problem([Blocks(seed)]) for seed in range(30)]
    left = [unexplained(each, each.replicate_residuals(())) for each in of]
    assert np.mean([u.is_significant for u in left]) <= 0.15
    assert all(u.score == 0 for u in left)


def test_something_left_in_one_place_alone_stands_out():
    of = Problem([Blocks(5, at_4=12.0)])
    left = unexplained(of, of.replicate_residuals(()))
    assert left.is_significant
    assert left.where == "statistic 4"
    assert left.score > 0.5
