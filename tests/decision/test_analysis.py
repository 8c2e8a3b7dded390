"""What follows from a study whose truth is known: 90 degrees are best for any sensor, pitch is nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tacos_decision import fronts
from tacos_decision.analysis import analyse
from tacos_decision.equivalence import equivalence
from tacos_decision.importance import sobol_indices
from tacos_decision.model import CameraModel
from tacos_decision.optimum import best_of_parts
from tacos_decision.pool import Pool
from tacos_decision.ranking import at_its_best
from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.study.sequential import compared
from tests.decision.recorded import recorded


@lru_cache
def analysed():
    return analyse(recorded())


@lru_cache
def model():
    return CameraModel.fit(recorded())


def test_a_score_of_a_task_may_be_called_fitness():
    record, named = recorded(), Fitness((FitnessTerm("width.fitness", 1.0),))
    episodes = (replace(e, scores={"width.fitness": e.scores["width.closeness"]}) for e in record.episodes)
    problem = replace(record.problem, fitness=named, scales={}, depends_on={})
    found = CameraModel.fit(replace(record, episodes=tuple(episodes), problem=problem))
    some = [episode.camera for episode in record.episodes[:5]]
    np.testing.assert_allclose(found.posterior(some).mean, model().posterior(some).mean, rtol=1e-6)


def test_every_part_is_ranked_at_its_own_best_optics():
    record, ranking = recorded(), analysed()["ranking"]
    catalog = next(variable for variable in record.space.variables if variable.name == "sensor")
    assert {row["part"] for row in ranking} == {row.name for row in catalog.rows}
    assert [row["fitness"] for row in ranking] == sorted((r["fitness"] for r in ranking), reverse=True)
    assert all(row["camera"]["sensor"]["name"] == row["part"] for row in ranking)
    assert not any(record.broken(row["camera"]) for row in ranking)
    fields_of_view = [record.derived(row["camera"])["hfov_deg"] for row in ranking]
    assert np.quantile(np.abs(np.array(fields_of_view) - 90), 0.75) < 12
    assert all(low <= row["fitness"] <= high for row in ranking for low, high in [row["ci"]])
    assert {name for row in ranking for name in row["p_better"]} == {
        "oak_d_pro_wide",
        "flea3",
        "basler_dart",
    }
    assert all(0 <= p <= 1 for row in ranking for p in row["p_better"].values())


def test_what_the_test_left_open_is_no_certainty_of_the_ranking():
    record = recorded()
    astray = compared([0.9, 0.8, 0.9, 1.0, 0.8, 0.9, 0.9, -2.0], error=0.05, margin=0.01)
    assert astray.verdict == "undecided"
    product = replace(record.cameras[1], free=())
    cameras = tuple(product if each.name == product.name else each for each in record.cameras)
    tested = replace(record, cameras=cameras, comparisons={**record.comparisons, product.name: astray})
    rows = analyse(tested)["ranking"]
    own = next(row for row in rows if row["camera"] == record.cameras[0].camera)
    share_above_zero = (astray.quantiles(np.linspace(0.0005, 0.9995, 1000)) > 0).mean()
    assert own["p_better"][product.name] == pytest.approx(share_above_zero, abs=0.001)
    others = [row["p_better"][product.name] for row in rows if row is not own]
    assert max(others) <= 0.99, "the model carries the doubt to every part"


def test_a_product_is_compared_at_its_own_best_wherever_its_search_has_ended():
    record, scored = recorded(), recorded().cameras[0]
    astray = {**scored.camera, "focal_length_mm": 20.0}
    product = replace(scored, name="product", camera=astray, free=("focal_length_mm", "pitch_deg"))
    best = at_its_best(model(), product, astray, margin=0.01)
    assert best["sensor"] == astray["sensor"]
    assert abs(record.derived(best)["hfov_deg"] - 90) < 15
    fixed = replace(product, free=())
    assert at_its_best(model(), fixed, astray, margin=0.01) == astray
    assert at_its_best(model(), product, astray, margin=10.0) == astray, "what it was scored with stands"


def test_what_was_scored_again_is_said():
    ranking, designed = analysed()["ranking"], recorded().cameras[0].camera
    scored = [row for row in ranking if row["rescored"]]
    assert designed["sensor"]["name"] in {row["part"] for row in scored}
    assert all((row["episodes"] > 0) for row in scored)
    assert min(row["ci"][1] - row["ci"][0] for row in ranking if row["rescored"]) < np.median(
        [row["ci"][1] - row["ci"][0] for row in ranking if row["episodes"] == 0]
    )


def test_intervals_hold_the_truth():
    """What a camera of that field of view scores in this toy, but for light that varies by scene."""
    record, ranking = recorded(), analysed()["ranking"]
    held = 0
    for row in ranking:
        truth = 1 - abs(record.derived(row["camera"])["hfov_deg"] - 90) / 180
        held += row["ci"][0] - 0.015 <= truth <= row["ci"][1] + 0.015  # the scenes' light adds up to 0.02
    assert held / len(ranking) >= 0.85


def test_the_best_is_among_its_equals_and_pitch_may_be_anything():
    found = analysed()["equivalent"]
    assert analysed()["ranking"][0]["part"] in found["parts"]
    assert found["range"]["pitch_deg"][0] < -20 < 20 < found["range"]["pitch_deg"][1]
    assert found["tolerance"]["pitch_deg"] == [-30, 30]
    low, high = found["tolerance"]["focal_length_mm"]
    designed = recorded().cameras[0].camera
    assert low <= designed["focal_length_mm"] <= high
    ends = [recorded().derived({**designed, "focal_length_mm": f})["hfov_deg"] for f in (low, high)]
    assert ends[0] - ends[1] < 25  # one per cent of the fitness is two degrees


def test_draws_of_the_best_camera_lie_at_90_degrees_and_add_up():
    optimal = analysed()["equivalent"]["optimal"]
    shares = [each["probability"] for each in optimal]
    assert sum(shares) == pytest.approx(1)
    assert shares == sorted(shares, reverse=True)
    near = sum(each["probability"] for each in optimal if 75 < each["derived"]["hfov_deg"] < 105)
    assert near > 0.9
    assert all(isinstance(each["camera"]["sensor"], str) for each in optimal)


@given(st.floats(0, 0.2), st.floats(0, 0.2))
@settings(max_examples=3, deadline=None)
def test_a_wider_margin_has_no_fewer_equals(share, more):
    pool = Pool(recorded().space)
    found = best_of_parts_once()
    few, many = (
        equivalence(model(), pool, found, Fitness((FitnessTerm("width.closeness", 1.0, margin),)))
        for margin in (share, share + more)
    )
    assert set(few["parts"]) <= set(many["parts"])
    for name, (low, high) in few["range"].items():
        assert many["range"][name][0] <= low <= high <= many["range"][name][1]
        assert few["tolerance"][name][0] >= many["tolerance"][name][0]
        assert few["tolerance"][name][1] <= many["tolerance"][name][1]


@given(st.floats(-100, 100))
@example(40.0)
@settings(max_examples=2, deadline=None)
def test_what_is_added_to_the_fitness_changes_no_equals_and_no_ranking(constant):
    plain, moved = (_analysed_with(added) for added in (0.0, constant))
    assert moved["equivalent"]["parts"] == plain["equivalent"]["parts"]
    assert moved["equivalent"]["margin"] == plain["equivalent"]["margin"]
    assert moved["equivalent"]["tolerance"] == plain["equivalent"]["tolerance"]
    assert [row["part"] for row in moved["ranking"]] == [row["part"] for row in plain["ranking"]]
    for row, before in zip(moved["ranking"], plain["ranking"], strict=True):
        assert row["fitness"] == pytest.approx(before["fitness"] + constant, abs=1e-3)
        assert row["p_better"] == pytest.approx(before["p_better"], abs=0.02)


@lru_cache
def _analysed_with(constant: float):
    """What follows from the study where its score is larger by a constant."""
    record = recorded()
    episodes = tuple(
        replace(e, scores={**e.scores, "width.closeness": e.scores["width.closeness"] + constant})
        for e in record.episodes
    )
    problem = replace(record.problem, scales={})
    return analyse(replace(record, episodes=episodes, problem=problem))


@lru_cache
def best_of_parts_once():
    return best_of_parts(model(), Pool(recorded().space))


def test_what_decides_the_field_of_view_matters_and_pitch_does_not():
    rows = {row["variable"]: row for row in analysed()["importance"]}
    assert rows["pitch_deg"]["total"] < 0.02
    assert rows["focal_length_mm"]["total"] > 0.3
    totals = [row["total"] for row in analysed()["importance"]]
    assert totals == sorted(totals, reverse=True)
    assert all(p["low"] <= p["mean"] <= p["high"] for row in rows.values() for p in row["curve"])
    pitch = [point["mean"] for point in rows["pitch_deg"]["curve"]]
    assert max(pitch) - min(pitch) < 0.01


def test_sobol_indices_are_those_of_the_ishigami_function():
    """T. Ishigami, T. Homma, ISUMA 1990; a = 7, b = 0.1."""

    def ishigami(rows):
        x, y, z = (2 * rows.T - 1) * np.pi
        return np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)

    first, total = sobol_indices(ishigami, 3, samples=8192)
    np.testing.assert_allclose(first, [0.3139, 0.4424, 0.0], atol=0.02)
    np.testing.assert_allclose(total, [0.5576, 0.4424, 0.2437], atol=0.02)


def test_a_constant_has_no_important_variable():
    first, total = sobol_indices(lambda rows: np.full(len(rows), 3.0), 2)
    assert not first.any()
    assert not total.any()


def test_a_study_without_a_winner_is_not_analysed():
    assert analyse(replace(recorded(), degenerate="All score zero.")) == {}


def test_equal_scores_are_no_ranking():
    episodes = tuple(replace(e, scores=dict.fromkeys(e.scores, 0.5)) for e in recorded().episodes)
    found = analyse(replace(recorded(), episodes=episodes))
    assert set(found) == {"ranking_absent"}
    assert "equal scores" in found["ranking_absent"]


def test_parts_that_cannot_keep_a_constraint_are_named_with_the_reason():
    def broken(camera):
        small = camera["sensor"]["name"] == analysed()["ranking"][0]["part"]
        return {"megapixels": 1.5} if small else recorded().broken(camera)

    found = analyse(replace(recorded(), broken=broken))
    (left_out,) = found["ranking_left_out"]
    assert left_out["part"] == analysed()["ranking"][0]["part"]
    assert "megapixels by 1.5" in left_out["why"]
    assert left_out["part"] not in {row["part"] for row in found["ranking"]}
    assert left_out["part"] not in found["equivalent"]["parts"]


# fronts -------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Objective:
    """As a recipe has one."""

    name: str
    unit: str
    aim: str

    def value(self, values, derived, scores):
        return {**derived, **scores}.get(self.name)


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=30))
def test_nobody_beats_those_on_the_front_and_somebody_each_of_the_others(aims):
    kept = fronts.undominated(np.array(aims, dtype=np.float64))

    def beaten(a):
        return any(b != a and b[0] <= a[0] and b[1] <= a[1] for b in aims)

    assert kept == [i for i, a in enumerate(aims) if not beaten(a)]


def test_a_front_trades_fitness_for_pixels_and_is_scored_again():
    pytest.importorskip("pymoo")
    scored = []

    def score(cameras, episodes):
        scored.extend(cameras)
        return [[replace(recorded().episodes[0], camera=camera, episode="analysis/0")] for camera in cameras]

    objectives = (Objective("fitness", "1", "max"), Objective("megapixels", "Mpx", "min"))
    record = replace(recorded(), objectives=objectives, score=score)
    found, learnt = fronts.front(model=CameraModel.fit(record), pool=Pool(record.space))
    assert found is not None
    assert all(learnt.episodes_of(camera) for camera in scored), "the ranking is to know of them"
    assert 0 < len(scored) <= fronts.MOST_SCORED
    values = np.array([[p["values"]["fitness"], p["values"]["megapixels"]] for p in found["points"]])
    assert (np.diff(values[:, 0]) <= 0).all()
    assert any(point["rescored"] for point in found["points"])


def test_without_objectives_there_is_no_front():
    assert "front" not in analysed()
