"""The sequential test: its error rate under peeking, what it decides, and when it cannot tell."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import stdtrit

from tacos_framework.study.sequential import compared, confidence_interval, error_at, looks

MOST = 30
"""Scenes of a long test."""

STUDIES = 400
"""Simulated studies; a rate of 5 % is then known to 1.1 %."""

DRAWS = {
    "normal": (lambda rng: rng.standard_normal(MOST), 0.05),
    "student, 3 degrees of freedom": (lambda rng: rng.standard_t(3, MOST), 0.05),
    "laplace": (lambda rng: rng.laplace(size=MOST), 0.05),
    "uniform": (lambda rng: rng.uniform(-1, 1, MOST), 0.05),
    "skewed: gamma, shape 4": (lambda rng: rng.gamma(4, size=MOST) - 4, 0.05),
    "skewed: exponential": (lambda rng: rng.exponential(size=MOST) - 1, 0.07),
    "one threshold in ten overlooked": (
        lambda rng: rng.normal(0, 0.3, MOST) + (rng.random(MOST) < 0.1) - 0.1,
        0.06,
    ),
}
"""Differences of mean zero, and the largest share of studies that may ever call one camera better."""


@pytest.mark.parametrize("name", DRAWS)
def test_looking_several_times_errs_no_more_often_than_stated(name):
    draw, most = DRAWS[name]
    rng = np.random.default_rng(5)
    counts = looks(8, MOST)
    wrong = 0
    for _ in range(STUDIES):
        seen = draw(rng)
        ends = (confidence_interval(seen[:count], error_at(count, counts, 0.05)) for count in counts)
        wrong += any(end is not None and not end[0] <= 0 <= end[1] for end in ends)
    assert wrong / STUDIES <= most + 0.01


@given(st.integers(1, 40), st.integers(0, 100), st.floats(0.001, 0.2))
def test_the_looks_spend_the_whole_error_and_no_more(first, more, error):
    counts = looks(first, first + more)
    parts = [error_at(count, counts, error) for count in counts]
    assert min(parts) > 0
    assert sum(parts) == pytest.approx(error)


def test_student_s_interval_would_err_far_more_often():
    rng = np.random.default_rng(5)
    wrong = 0
    for _ in range(STUDIES):
        seen = rng.standard_normal(MOST)
        counts = np.arange(3, MOST + 1)
        means = np.array([seen[:n].mean() for n in counts])
        errors = np.array([seen[:n].std(ddof=1) / np.sqrt(n) for n in counts])
        wrong += bool((np.abs(means) > stdtrit(counts - 1, 0.975) * errors).any())
    assert wrong / STUDIES > 0.15


def test_a_difference_as_large_as_its_spread_is_found_within_twenty_scenes():
    rng = np.random.default_rng(0)
    needed = []
    for _ in range(100):
        seen, counts = rng.standard_normal(40) + 1, looks(8, 40)
        verdicts = (
            (n, compared(seen[:n], error=error_at(n, counts, 0.05), margin=0).verdict) for n in counts
        )
        needed.append(next(n for n, verdict in verdicts if verdict == "better"))
    assert np.median(needed) <= 20


values = st.lists(st.floats(-10, 10, width=32), min_size=7, max_size=20)


@given(values, st.floats(-5, 5), st.floats(0.1, 10))
@settings(max_examples=50, deadline=None)
def test_the_interval_moves_and_scales_with_the_differences(seen, shift, scale):
    plain = np.array(seen, dtype=np.float64)
    ends = confidence_interval(plain, 0.05)
    moved = confidence_interval(plain * scale + shift, 0.05)
    if ends is None or moved is None or np.ptp(plain) < 1e-3:
        return
    np.testing.assert_allclose(moved, np.array(ends) * scale + shift, rtol=1e-6, atol=1e-6)


@given(values)
@settings(max_examples=50, deadline=None)
def test_exchanging_the_cameras_exchanges_the_verdict(seen):
    there = compared(seen, error=0.05, margin=0.1)
    back = compared([-value for value in seen], error=0.05, margin=0.1)
    opposite = {"better": "worse", "worse": "better"}
    assert back.verdict == opposite.get(there.verdict, there.verdict)
    assert back.difference == pytest.approx(-there.difference)


@given(values, st.floats(0, 1), st.floats(0, 5))
@settings(max_examples=50, deadline=None)
def test_a_wider_margin_never_undoes_an_equivalence(seen, margin, more):
    if compared(seen, error=0.05, margin=margin).verdict == "equivalent":
        assert compared(seen, error=0.05, margin=margin + more).verdict == "equivalent"


def test_no_difference_that_matters_is_equivalent_even_where_it_is_certain():
    seen = 0.005 + 0.0005 * np.random.default_rng(0).standard_normal(12)
    assert compared(seen, error=0.05, margin=0.01).verdict == "equivalent"
    assert compared(seen, error=0.05, margin=0.001).verdict == "better"


@pytest.mark.parametrize("count", [0, 1, 2])
def test_two_scenes_tell_nothing(count):
    found = compared([1.0, 1.1][:count], error=0.05, margin=0.01)
    assert (found.interval, found.verdict, found.episodes) == (None, "undecided", count)


def test_differences_that_are_all_alike_need_as_many_scenes_as_a_fair_coin():
    verdicts = [compared([0.25] * n, error=0.05, margin=0.01).verdict for n in range(1, 9)]
    assert verdicts == ["undecided"] * 5 + ["better"] * 3  # 2 ** (1 - 6) < 0.05
    assert compared([0.0] * 6, error=0.05, margin=0.01).verdict == "equivalent"


@given(st.integers(1, 50), st.integers(0, 200))
def test_looks_rise_from_the_first_to_the_most(first, more):
    counts = looks(first, first + more)
    assert (counts[0], counts[-1]) == (first, first + more)
    assert all(a < b for a, b in pairwise(counts))


def test_quantiles_of_a_difference_end_where_its_interval_does():
    values = np.array([0.9, 0.8, 0.9, 1.0, 0.8, 0.9, 0.9, -2.0])
    found = compared(values, error=0.1, margin=0.0)
    np.testing.assert_allclose(found.quantiles(np.array([0.05, 0.95])), found.interval)
    shares = np.linspace(0.001, 0.999, 200)
    assert (np.diff(found.quantiles(shares)) > 0).all()
    assert compared(values[:2], error=0.1, margin=0.0).quantiles(shares) is None
