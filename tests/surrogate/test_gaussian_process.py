"""The Gaussian process of one score."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from tacos_plugins.surrogate.evidence import Evidence, fit_hyperparameters
from tacos_plugins.surrogate.gaussian_process import (
    MEAN_VARIANCE,
    GaussianProcess,
    Inputs,
    covariance,
    factorised,
)
from tacos_plugins.surrogate.kernel import NO_EPISODE, scaled_distances, squared_differences
from tests.surrogate.drawn import TRUE, inputs_of, values_of


def matern_52(first, second, h) -> float:
    """Written out for one pair, with the distance in length scales."""
    r = math.sqrt(5 * sum(((a - b) / s) ** 2 for a, b, s in zip(first, second, h.length_scales, strict=True)))
    return (1 + r + r**2 / 3) * math.exp(-r)


def test_predictions_are_those_of_the_joint_gaussian_written_out():
    """The formula for conditioning, from a matrix filled entry by entry, solved without a factorisation."""
    rng = np.random.default_rng(3)
    inputs, h = inputs_of(rng, 9), TRUE
    values, points = values_of(rng, inputs), rng.random((4, 3))
    k = np.empty((9, 9))
    for i in range(9):
        for j in range(9):
            near = matern_52(inputs.points[i], inputs.points[j], h)
            same = inputs.episodes[i] == inputs.episodes[j]
            k[i, j] = h.signal**2 * near + MEAN_VARIANCE + (i == j) * h.noise**2
            k[i, j] += same * (h.episode**2 + h.interaction**2 * near)
    across = np.array(
        [[h.signal**2 * matern_52(x, p, h) + MEAN_VARIANCE for p in points] for x in inputs.points]
    )
    prior = np.array([[h.signal**2 * matern_52(p, q, h) + MEAN_VARIANCE for q in points] for p in points])
    expected = across.T @ np.linalg.solve(k, values)
    expected_covariance = prior - across.T @ np.linalg.solve(k, across)

    process = GaussianProcess(inputs, values, h)
    prediction = process.at(points)
    np.testing.assert_allclose(prediction.mean, expected, rtol=1e-9)
    np.testing.assert_allclose(prediction.covariance, expected_covariance, rtol=1e-7, atol=1e-10)
    np.testing.assert_allclose(prediction.sd, np.sqrt(np.diag(expected_covariance)), rtol=1e-7)


def test_the_evidence_is_the_density_of_the_values_times_that_of_the_prior():
    rng = np.random.default_rng(5)
    inputs = inputs_of(rng, 12)
    evidence = Evidence(inputs, values_of(rng, inputs))
    mean, spread = evidence.prior

    def log_density(h):
        likelihood = multivariate_normal(np.zeros(12), covariance(inputs, h)).logpdf(evidence.values)
        return likelihood - 0.5 * np.sum(((evidence.logarithms(h) - mean) / spread) ** 2)

    other = replace(TRUE, noise=0.4, length_scales=(1.0, 0.3, 0.7))
    loss, of_other = (evidence.loss(evidence.logarithms(h))[0] for h in (TRUE, other))
    assert of_other - loss == pytest.approx(log_density(TRUE) - log_density(other), rel=1e-9)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32), scenes=st.booleans(), drift=st.booleans(), untold=st.booleans())
def test_its_gradient_is_that_of_finite_differences(seed, scenes, drift, untold):
    rng = np.random.default_rng(seed)
    points = rng.random((15, 2))
    if untold:
        points[rng.random((15, 2)) < 0.2] = np.nan
    episodes = rng.integers(0, 3, 15) if scenes else np.full(15, NO_EPISODE)
    inputs = Inputs(points, episodes, np.linspace(0, 1, 15) if drift else None)
    evidence = Evidence(inputs, rng.standard_normal(15))
    at = evidence.prior[0] + rng.uniform(-1, 1, len(evidence.prior[0]))
    steps = 1e-5 * np.eye(len(at))
    numeric = [(evidence.loss(at + s)[0] - evidence.loss(at - s)[0]) / 2e-5 for s in steps]
    np.testing.assert_allclose(evidence.loss(at)[1], numeric, rtol=1e-4, atol=1e-5)


@given(seed=st.integers(0, 2**32))
def test_distances_are_the_sum_of_those_along_each_coordinate(seed):
    rng = np.random.default_rng(seed)
    first, second, scales = rng.random((5, 3)), rng.random((4, 3)), rng.uniform(0.2, 2, 3)
    first[rng.random((5, 3)) < 0.3] = np.nan
    second[rng.random((4, 3)) < 0.3] = np.nan
    expected = np.einsum("kij,k->ij", squared_differences(first, second), scales**-2.0)
    np.testing.assert_allclose(scaled_distances(first, second, scales), expected, atol=1e-12)


def test_true_values_lie_in_its_intervals_as_often_as_they_say():
    """Points withheld from forty draws of the model, hyperparameters fitted to forty observations each."""
    within = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        inputs = inputs_of(rng, 140)
        rest = np.arange(40, 140)
        total = covariance(inputs, replace(TRUE, episode=0, interaction=0, noise=1e-3))
        smooth = factorised(total) @ rng.standard_normal(140)
        scenes = (
            values_of(rng, inputs, replace(TRUE, signal=1e-6)) - rng.standard_normal()
        )  # its own mean out
        taken = np.arange(40)
        values = smooth[taken] + scenes[taken] - scenes[taken].mean()
        process_inputs = inputs.take(taken)
        process = GaussianProcess(process_inputs, values, fit_hyperparameters(process_inputs, values))
        prediction = process.at(inputs.points[rest])
        within.extend(np.abs(smooth[rest] - prediction.mean) < 1.96 * prediction.sd)
    assert 0.90 < np.mean(within) < 0.985


def test_hyperparameters_come_out_of_many_observations():
    rng = np.random.default_rng(1)
    inputs = inputs_of(rng, 250, episodes=10)
    found = fit_hyperparameters(inputs, values_of(rng, inputs))
    assert found.noise == pytest.approx(TRUE.noise, rel=0.3)
    assert found.episode == pytest.approx(TRUE.episode, rel=0.7)
    np.testing.assert_allclose(np.log(found.length_scales[:2]), np.log(TRUE.length_scales[:2]), atol=0.5)
    assert found.length_scales[2] > 1.5


def test_starting_from_what_was_found_finds_it_again():
    rng = np.random.default_rng(2)
    inputs = inputs_of(rng, 60)
    values = values_of(rng, inputs)
    found = fit_hyperparameters(inputs, values)
    again = fit_hyperparameters(inputs, values, start=found)
    np.testing.assert_allclose(again.length_scales, found.length_scales, rtol=0.02)


def test_what_an_observation_would_tell_is_what_it_tells():
    """The variance that is said to go once a point is observed goes when it is, in a scene of its own."""
    rng = np.random.default_rng(4)
    inputs = inputs_of(rng, 20)
    values, points = values_of(rng, inputs), rng.random((6, 3))
    process = GaussianProcess(inputs, values, TRUE)
    more = Inputs(np.vstack([inputs.points, points[:1]]), np.append(inputs.episodes, 99))
    after = GaussianProcess(more, np.append(values, 0.0), TRUE)
    before = process.at(points)
    np.testing.assert_allclose(before.having_seen(0).sd, after.at(points).sd, rtol=1e-6)
    np.testing.assert_allclose(before.having_seen(0).covariance, after.at(points).covariance, atol=1e-9)


def test_an_unknown_coordinate_widens_the_interval():
    rng = np.random.default_rng(6)
    inputs = inputs_of(rng, 60)
    process = GaussianProcess(inputs, values_of(rng, inputs), TRUE)
    known = np.full((1, 3), 0.5)
    unknown = np.array([[np.nan, 0.5, 0.5]])
    assert process.at(unknown).sd > 2 * process.at(known).sd


def test_a_drift_is_told_from_the_points_and_predictions_are_for_the_end():
    rng = np.random.default_rng(7)
    times = np.linspace(0, 1, 80)
    inputs = Inputs(rng.random((80, 1)), np.full(80, NO_EPISODE), times)
    values = np.sin(5 * inputs.points[:, 0]) + 2 * times + 0.02 * rng.standard_normal(80) - 1
    process = GaussianProcess(inputs, values, fit_hyperparameters(inputs, values))
    points = np.linspace(0.1, 0.9, 9)[:, None]
    np.testing.assert_allclose(process.at(points).mean, np.sin(5 * points[:, 0]) + 1, atol=0.15)


def test_a_matrix_that_is_no_covariance_is_refused():
    with pytest.raises(np.linalg.LinAlgError, match="no covariance"):
        factorised(np.array([[1.0, 2.0], [2.0, 1.0]]))
