"""What optimizers are told of a study's problem before anything is rendered."""

from __future__ import annotations

import math

import numpy as np
import pytest
import toy_plugin
from hypothesis import given, settings
from hypothesis import strategies as st
from toy_study import FROM_CATALOG, merged, toy_recipe

from tacos_framework.errors import ContractBroken
from tacos_framework.plan import make_plan
from tacos_framework.recipe import Recipe
from tacos_framework.simulation import EpisodeSpec, Evaluator, ScoreJob
from tacos_framework.study.problem import broken_by, coordinates_of, design_problem
from tacos_plugins.rigs.monocular import MonocularRig

SETTINGS = {
    "effects": [{"use": "effect.toy-invert", "name": "shade"}],
    "design": {
        "effects.shade.share": {"between": [0, 1]},
        "effects.shade.mode": {"choose": ["all", "red"]},
        "scenario.gain_db": {"choose": [0, 6, 12]},
    },
    "constraints": {"hfov_deg": {"min": 40, "max": 100}},
}


@pytest.fixture
def declaring(monkeypatch):
    """A rig and a task that say what images and scores depend on."""

    def coordinates(self, variables):
        return {"log2_focal": math.log2(variables.focal_length_mm)}

    monkeypatch.setattr(MonocularRig, "coordinates", coordinates, raising=False)
    for name in ("score_scales", "depends_on"):
        monkeypatch.setattr(toy_plugin.WidthTask, name, {}, raising=False)


@pytest.fixture
def undeclared(monkeypatch):
    """A third party's rig that says nothing of coordinates."""
    monkeypatch.delattr(MonocularRig, "coordinates", raising=False)


def plan_of(toys, recipe=None, **sections):
    return make_plan(recipe or toy_recipe(**sections), toys)


def test_a_rig_that_declares_coordinates_speaks_for_its_variables(toys, declaring):
    plan = plan_of(toys, **SETTINGS)
    values = {
        "focal_length_mm": 4.0,
        "pitch_deg": 3.0,
        "effects.shade.share": 0.25,
        "effects.shade.mode": "red",
    }
    assert coordinates_of(plan, {**values, "scenario.gain_db": 6}) == {
        "log2_focal": 2.0,
        "effects.shade.share": 0.25,
        "effects.shade.mode": 1.0,
        "scenario.gain_db": 6.0,
    }


def test_of_another_rig_they_are_what_it_derives_and_its_numbers(toys, undeclared):
    recipe = Recipe.model_validate(merged(FROM_CATALOG, {"optimizer": {"generations": 2}}))
    plan = plan_of(toys, recipe)
    names = set()
    rng = np.random.default_rng(1)
    for _ in range(50):
        found = design_problem(plan).coordinates(plan.space.sample(rng))
        assert all(math.isfinite(value) for value in found.values())
        names.add(tuple(found))
    known = set.intersection(
        *map(set, names)
    )  # what is unknown of one part, such as its power, it leaves out
    assert {"hfov_deg", "focal_length_mm", "pitch_deg", "sensor.pixel_um", "sensor.width_px"} <= known
    assert "sensor.name" not in known


def test_what_a_product_fixes_counts(toys, undeclared):
    plan = plan_of(toys)
    free = plan.space.fix(["focal_length_mm"])
    told = design_problem(plan, {"focal_length_mm": 2.0}).coordinates(free.decode([5.0]))
    assert (told["focal_length_mm"], told["pitch_deg"]) == (2.0, 5.0)


def test_a_rig_that_gives_no_number_is_named(toys, monkeypatch):
    monkeypatch.setattr(
        MonocularRig, "coordinates", lambda self, variables: {"hfov_deg": math.nan}, raising=False
    )
    plan = plan_of(toys)
    with pytest.raises(ContractBroken, match=r"rig\.monocular.* gives nan as 'hfov_deg'"):
        coordinates_of(plan, {"focal_length_mm": 2.0, "pitch_deg": 0.0})


@given(focal_length_mm=st.floats(0.5, 5), pitch_deg=st.floats(-30, 30))
@settings(max_examples=30, deadline=None)
def test_what_is_told_before_is_what_comes_out_after(toys, focal_length_mm, pitch_deg):
    """A constraint is broken by as much when it is asked about as when the candidate is evaluated."""
    plan = plan_of(toys, constraints=SETTINGS["constraints"])
    values = {"focal_length_mm": focal_length_mm, "pitch_deg": pitch_deg}
    evaluation = Evaluator(plan, toys)(ScoreJob(values, (EpisodeSpec(3, ("design", 0, 0)),)))
    broken = broken_by(plan, values)
    assert broken == evaluation.broken
    hfov_deg = evaluation.derived["hfov_deg"]
    expected = max(40 - hfov_deg, hfov_deg - 100)
    assert broken == ({"hfov_deg": pytest.approx(expected)} if expected > 0 else {})
    assert bool(broken) == (evaluation.fitness is None) == (evaluation.images == 0)


def test_what_the_rig_refuses_breaks_the_rig(toys):
    plan = plan_of(toys)
    values = {"focal_length_mm": -2.0, "pitch_deg": 0.0}
    assert broken_by(plan, values) == {"rig": 1.0}
    evaluation = Evaluator(plan, toys)(ScoreJob(values, (EpisodeSpec(3, ("design", 0, 0)),)))
    assert evaluation.broken == {"rig": 1.0}


def test_scores_say_their_scale_and_what_they_depend_on(toys, declaring, monkeypatch):
    monkeypatch.setattr(toy_plugin.WidthTask, "score_scales", {"closeness": "share"})
    monkeypatch.setattr(toy_plugin.WidthTask, "depends_on", {"closeness": ("log2_focal",)})
    problem = design_problem(plan_of(toys, **SETTINGS))
    assert problem.scales == {"width.closeness": "share"}
    settable = (
        "effects.shade.share",
        "effects.shade.mode",
        "scenario.gain_db",
    )  # the task speaks of the rig alone
    assert problem.depends_on == {"width.closeness": ("log2_focal", *settable)}


def test_a_score_that_names_what_this_rig_lacks_may_depend_on_anything(toys, declaring, monkeypatch):
    monkeypatch.setattr(toy_plugin.WidthTask, "depends_on", {"closeness": ("log2_focal", "baseline_m")})
    assert design_problem(plan_of(toys)).depends_on == {}


@pytest.mark.parametrize(("renew", "renews"), [("never", False), ("each_generation", True)])
def test_each_block_counts_as_an_episode(toys, renew, renews):
    problem = design_problem(plan_of(toys, study={"episodes": 2, "blocks": 3, "renew_episodes": renew}))
    assert (problem.episodes, problem.episodes_renew) == (6, renews)
