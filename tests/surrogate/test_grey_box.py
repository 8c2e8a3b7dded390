"""The fitness, from models of its scores."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_plugins.surrogate.grey_box import GreyBox, Observation
from tacos_plugins.surrogate.score_model import MOST_OBSERVATIONS
from tacos_plugins.surrogate.transforms import counted

FITNESS = Fitness((FitnessTerm("orb.inliers", 0.01), FitnessTerm("door.seen", 0.5)))
SCALES = {"orb.inliers": "count", "door.seen": "share"}


def inliers(x: float) -> float:
    return 100 * np.exp(-(((x - 80) / 30) ** 2))


def seen(x: float) -> float:
    return 1 / (1 + np.exp(-(x - 60) / 10))


def observations(rng: np.random.Generator, count: int = 60, scenes: int = 4) -> list[Observation]:
    """Cameras of 30 to 120 degrees, each in one scene that makes all of them better or worse."""
    gains = 1 + 0.1 * rng.standard_normal(scenes)
    found = []
    for i, x in enumerate(rng.uniform(30, 120, count)):
        scores = {
            "orb.inliers": rng.poisson(max(gains[i % scenes], 0) * inliers(x)),
            "door.seen": rng.binomial(20, seen(x)) / 20,
        }
        found.append(Observation({"hfov_deg": x, "idle": rng.random()}, i % scenes, scores))
    return found


def test_the_fitness_is_found_within_its_own_error():
    points = [{"hfov_deg": x, "idle": 0.5} for x in np.linspace(35, 115, 17)]
    truth = np.array([0.01 * inliers(p["hfov_deg"]) + 0.5 * seen(p["hfov_deg"]) for p in points])
    misses = []
    for seed in range(5):
        model = GreyBox.fit(observations(np.random.default_rng(seed)), FITNESS, SCALES)
        posterior = model.posterior(points)
        misses.append((posterior.mean - truth) / posterior.sd)
        assert np.abs(posterior.mean - truth).max() < 0.2
    assert 0.5 < np.sqrt(np.mean(np.square(misses))) < 1.6


def test_draws_have_the_means_and_deviations_of_the_posterior_and_move_together():
    model = GreyBox.fit(observations(np.random.default_rng(1)), FITNESS, SCALES)
    posterior = model.posterior([{"hfov_deg": x, "idle": 0.5} for x in (60.0, 61.0, 110.0)])
    draws = posterior.draws(4000, np.random.default_rng(2))
    np.testing.assert_allclose(draws.mean(axis=0), posterior.mean, atol=4 * posterior.sd.max() / 60)
    np.testing.assert_allclose(draws.std(axis=0), posterior.sd, rtol=0.06)
    correlation = np.corrcoef(draws.T)
    assert correlation[0, 1] > 0.95
    assert correlation[0, 1] > correlation[0, 2] + 0.2


def test_a_score_is_modelled_from_the_scenes_that_report_it():
    found = observations(np.random.default_rng(1))
    some = [
        Observation(o.coordinates, o.episode, dict(list(o.scores.items())[: 1 + i % 2]))
        for i, o in enumerate(found)
    ]
    model = GreyBox.fit(some, FITNESS, SCALES)
    assert model.degenerate is None
    assert len(model.models["door.seen"].process.inputs) == 30


def test_scores_depend_on_what_they_say_they_do():
    found = observations(np.random.default_rng(1))
    model = GreyBox.fit(
        found, FITNESS, SCALES, {"door.seen": ("hfov_deg", "vfov_deg"), "orb.inliers": ("x",)}
    )
    assert len(model.hyperparameters["door.seen"].length_scales) == 1
    assert len(model.hyperparameters["orb.inliers"].length_scales) == 2, "nothing of what it names is there"


@pytest.mark.parametrize(("over", "expected"), [("mean", 0.25 * 80 + 0.75 * 40), ("worst", 40)])
def test_several_scenarios_count_by_their_weights_or_the_worst_alone(over, expected):
    fitness = Fitness((FitnessTerm("orb.inliers", 1.0),), (("day", 1.0), ("night", 3.0)), over)
    found = [
        Observation({"pitch_deg": x}, e, {"day/orb.inliers": 80 + 0.1 * e, "night/orb.inliers": 40 + 0.1 * e})
        for x in np.linspace(-10, 10, 8)
        for e in (0, 1)
    ]
    posterior = GreyBox.fit(found, fitness, {"orb.inliers": "count"}).posterior([{"pitch_deg": 0.0}])
    assert posterior.mean[0] == pytest.approx(expected, rel=0.02)
    assert posterior.draws(100, np.random.default_rng(1)).mean() == pytest.approx(expected, rel=0.03)


def test_kept_hyperparameters_are_kept():
    found = observations(np.random.default_rng(1))
    model = GreyBox.fit(found[:30], FITNESS, SCALES)
    more = GreyBox.fit(found, FITNESS, SCALES, start=model.hyperparameters, fixed=True)
    assert more.hyperparameters == model.hyperparameters
    assert len(more.models["orb.inliers"].process.inputs) == 60


def test_of_too_many_observations_the_latest_are_kept():
    scores = [{"orb.inliers": float(i)} for i in range(MOST_OBSERVATIONS + 500)]
    found = [Observation({"x": float(i % 7)}, None, s) for i, s in enumerate(scores)]
    fitness = Fitness((FitnessTerm("orb.inliers", 1.0),))
    start = GreyBox.fit(found[:50], fitness).hyperparameters
    process = GreyBox.fit(found, fitness, start=start, fixed=True).models["orb.inliers"].process
    assert len(process.inputs) == MOST_OBSERVATIONS
    assert np.all(np.diff(process.values) > 0), "in their order, none twice"
    assert np.diff(process.values)[-700:] == pytest.approx(process.values[-1] - process.values[-2])


@pytest.mark.parametrize(
    ("found", "sentence"),
    [
        ([], "nothing was observed"),
        ([{"orb.inliers": 3.0}] * 4, "no episode gave a value for door.seen, which the fitness needs"),
        ([{"orb.inliers": 0.0, "door.seen": 0.0}] * 8, "all scores of the 8 observations are zero"),
        ([{"orb.inliers": 3.0, "door.seen": 1.0}] * 8, "all 8 observations have equal scores"),
    ],
)
def test_observations_that_tell_nothing_are_said_to(found, sentence):
    given_ones = [Observation({"hfov_deg": 50.0 + i}, i % 2, scores) for i, scores in enumerate(found)]
    model = GreyBox.fit(given_ones, FITNESS, SCALES)
    assert model.degenerate == sentence
    posterior = model.posterior([{"hfov_deg": 50.0}, {"hfov_deg": 55.0}])
    assert np.isfinite(posterior.mean).all()
    assert np.isfinite(posterior.draws(3, np.random.default_rng(1))).all()


def test_equal_cameras_are_said_to_be_equal():
    found = [
        Observation({"hfov_deg": 50.0}, i, {"orb.inliers": float(i), "door.seen": 0.5}) for i in range(4)
    ]
    assert (
        GreyBox.fit(found, FITNESS).degenerate == "all 4 observations are of cameras with equal coordinates"
    )


@settings(max_examples=25, deadline=None)
@given(
    rows=st.lists(
        st.tuples(
            st.floats(-1e6, 1e6), st.sampled_from([0.0, 1e-300, 1.0, 5.0]), st.none() | st.integers(0, 2)
        ),
        max_size=12,
    ),
    scale=st.sampled_from(["real", "count", "share"]),
)
def test_any_finite_scores_give_finite_answers(rows, scale):
    fitness = Fitness((FitnessTerm("a.b", 2.0),))
    found = [Observation({"x": x, "y": 1.0}, episode, {"a.b": score}) for score, x, episode in rows]
    posterior = GreyBox.fit(found, fitness, {"a.b": scale}).posterior([{"x": 0.5}, {"x": 2.0, "y": 3.0}])
    assert np.isfinite(posterior.mean).all()
    assert (posterior.sd >= 0).all()
    assert np.isfinite(posterior.draws(5, np.random.default_rng(1))).all()


def test_few_that_all_were_seen_are_no_proof_that_all_are_always_seen():
    """Of two thresholds a scene, a camera that sees nine of ten shows both in four scenes of five."""
    fitness = Fitness((FitnessTerm("door.seen", 1.0),))
    fovs_deg = [35.0, 40.0, 45.0, 80.0, 90.0, 100.0, 110.0, 120.0]

    def model(values) -> GreyBox:
        found = [Observation({"hfov_deg": x}, i, {"door.seen": v}) for i, (x, v) in enumerate(values)]
        return GreyBox.fit(found, fitness, {"door.seen": "share"})

    few = model([(x, float(x > 60)) for x in fovs_deg])
    many = model([(x, 0.9999 * float(x > 60)) for x in fovs_deg])  # of no whole number: counted well
    near_the_border = [{"hfov_deg": 76.0}]
    assert few.posterior(near_the_border).mean[0] < many.posterior(near_the_border).mean[0] - 0.02
    assert few.posterior(near_the_border).sd[0] > 1.5 * many.posterior(near_the_border).sd[0]


@pytest.mark.parametrize(
    ("shares", "count"),
    [
        ([0, 1], 1),
        ([0, 0.5, 1], 2),
        ([1 / 3, 0.5], 6),
        ([0.273, 1.0], None),
        ([7 / 12], 12),
        ([1 / 13], None),
    ],
)
def test_shares_of_few_are_known_by_their_denominator(shares, count):
    assert counted(np.array(shares, dtype=float)) == count
