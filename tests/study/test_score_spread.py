"""Shares of variance between cameras, against those that made the scores."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.study.score_spread import full_scores, score_spreads, share_between


@pytest.mark.parametrize(("between", "scatter"), [(1.0, 0.2), (1.0, 1.0), (0.3, 1.0)])
def test_the_share_is_that_which_made_the_scores(between, scatter):
    rng = np.random.default_rng(3)
    shares = []
    for _ in range(200):
        cameras, scenes = rng.normal(0, between, (12, 1)), rng.normal(0, 5, (1, 16))
        shares.append(share_between(cameras + scenes + rng.normal(0, scatter, (12, 16))))
    assert np.mean(shares) == pytest.approx(between**2 / (between**2 + scatter**2), abs=0.04)


@given(
    share=st.integers(0, 2**31),
    shape=st.tuples(st.integers(2, 6), st.integers(2, 9)),
    factor=st.floats(0.01, 100),
    shift=st.floats(-5, 5),
)
def test_shares_lie_between_0_and_1_whatever_the_unit(share, shape, factor, shift):
    scores = np.random.default_rng(share).uniform(0, 1, shape)
    found = share_between(scores)
    assert 0 <= found <= 1
    assert share_between(factor * scores + shift) == pytest.approx(found, abs=1e-6)


def test_equal_cameras_have_no_share():
    assert share_between(np.full((4, 8), 0.7)) == 0
    scenes = np.random.default_rng(0).uniform(0, 1, (1, 8))
    assert share_between(np.repeat(scenes, 4, axis=0)) == 0


def test_full_scores_are_named_with_what_to_change():
    rng = np.random.default_rng(1)
    blocks = [
        [{"pose.rotation": 0.2 * camera + 0.01 * rng.normal(), "seen.ratio": 1.0} for _ in range(8)]
        for camera in range(4)
    ]
    spreads = score_spreads(["pose.rotation", "seen.ratio"], blocks)
    assert not spreads["pose.rotation"].full
    assert spreads["seen.ratio"].full
    said = full_scores(spreads)
    assert said.startswith("These scores do not separate the cameras of the test: seen.ratio (at 1, 0 % of")
    assert "Choose scenes, light or motion" in said
    assert full_scores({"pose.rotation": spreads["pose.rotation"]}) is None
    assert full_scores({"seen.ratio": spreads["seen.ratio"]}).startswith("No score of the fitness separates")


def test_scenes_in_which_a_score_has_no_meaning_do_not_count():
    blocks = [[{"a": 1.0}, {}, {"a": 0.5}], [{"a": 0.8}, {"a": 9.0}, {"a": 0.3}]]
    assert score_spreads(["a", "b"], blocks)["a"].share_of_variance == 1
    assert set(score_spreads(["a", "b"], blocks)) == {"a"}
    assert score_spreads(["a"], blocks[:1]) == {}
