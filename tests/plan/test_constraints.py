"""Constraints on derived quantities and on columns of parts: what they leave, and what none keeps."""

from __future__ import annotations

import pytest
from toy_study import FROM_CATALOG

from tacos_framework.errors import UserError
from tacos_framework.plan import make_plan
from tacos_framework.plan.feasibility import infeasible
from tacos_framework.plan.notes import inadmissible, notes_on_camera, notes_on_constraints
from tacos_framework.recipe import Recipe
from tacos_framework.variables.design_space import CatalogChoice

LENS_AND_SENSOR = {
    "pitch_deg": {"between": [-30, 30]},
    "lens": {"from": "lenses", "scheme": "discrete"},
    "sensor": {"from": "image_sensors", "scheme": "discrete"},
}


def recipe(**sections):
    return Recipe.model_validate({**FROM_CATALOG, **sections})


def faults_of(toys, **sections):
    with pytest.raises(UserError) as caught:
        make_plan(recipe(**sections), toys)
    return [(fault.where, fault.what, fault.remedy) for fault in caught.value.faults]


def values_of(plan, lens, sensor):
    choices = {v.name: v for v in plan.space.variables if isinstance(v, CatalogChoice)}
    return {
        "pitch_deg": 0.0,
        "lens": choices["lens"].catalog.part(lens).as_dict(),
        "sensor": choices["sensor"].catalog.part(sensor).as_dict(),
    }


def derived(plan, values):
    return plan.rig.instance.derived(plan.rig_variables(values))


def test_parts_that_break_a_constraint_of_their_own_cannot_be_chosen(toys):
    constraints = {"sensor.shutter": {"is": "global"}, "sensor.pixel_um": {"min": 3, "max": 5}}
    plan = make_plan(recipe(constraints=constraints), toys)
    (choice,) = (v for v in plan.space.variables if isinstance(v, CatalogChoice))
    assert 5 < len(choice.rows) < 43
    assert all(row["shutter"] == "global" and 3 <= row.number("pixel_um") <= 5 for row in choice.rows)
    assert len(choice.rows) + len(choice.excluded) == 43


def test_unknown_values_pass_unless_they_are_refused(toys):
    def names(**bounds):
        plan = make_plan(recipe(constraints={"sensor.full_well_e": {"min": 10_000, **bounds}}), toys)
        (choice,) = (v for v in plan.space.variables if isinstance(v, CatalogChoice))
        return {row.name for row in choice.rows}, list(notes_on_constraints(plan))

    allowed, notes = names()
    refused, silent = names(unknown="refuse")
    assert {"IMX273", "PYTHON300"} <= allowed
    assert refused < allowed
    assert refused.isdisjoint({"PYTHON300", "MT9P031"})
    assert "MT9P031" not in allowed  # 6457 electrons
    assert silent == []
    (note,) = notes
    assert note.startswith("The constraint on sensor.full_well_e passes parts that do not publish it:")
    assert "PYTHON300" in note
    assert note.endswith(" more (sensor); unknown: refuse leaves them out.")


def test_a_constraint_that_only_unknown_values_pass_is_told(toys):
    plan = make_plan(recipe(constraints={"sensor.full_well_e": {"min": 10_000_000}}), toys)
    (note,) = notes_on_constraints(plan)
    assert note.startswith("No part with a published sensor.full_well_e keeps the constraint on it.")
    assert "PYTHON300" in note
    assert "IMX273" not in note  # known, and ruled out


@pytest.mark.parametrize(
    ("constraints", "what", "remedy"),
    [
        (
            {"sensor.shuter": {"is": "global"}},
            "no part to choose has a column 'sensor.shuter'",
            "sensor.shutter",
        ),
        ({"hfov": {"max": 9}}, "rig.monocular derives no 'hfov'", "hfov_deg"),
        ({"sensor.shutter": {"is": "globl"}}, "no part has 'globl' as sensor.shutter", "global"),
        ({"sensor.shutter": {"min": 1}}, "sensor.shutter is text, and has no smallest or largest value", ""),
        ({"sensor.pixel_um": {"is": "big"}}, "sensor.pixel_um is a number, and no word", ""),
        ({"hfov_deg": {"any_of": ["wide"]}}, "hfov_deg is a number, and no word", ""),
        ({"sensor.pixel_um": {}}, "'sensor.pixel_um' has no bound", ""),
    ],
)
def test_constraints_that_make_no_sense_are_told(toys, constraints, what, remedy):
    ((where, found, to_do),) = faults_of(toys, constraints=constraints)
    assert where == f"recipe.constraints.{next(iter(constraints))}"
    assert found == what
    assert remedy in to_do


def test_a_constraint_no_part_keeps_is_told_with_the_part_that_comes_nearest(toys):
    ((where, what, remedy),) = faults_of(
        toys, constraints={"sensor.pixel_um": {"min": 20}, "megapixels": {"max": 20}}
    )
    assert where == "recipe.constraints.sensor.pixel_um"
    assert what.startswith("none of ")
    assert what.endswith(" is 9, below the smallest allowed value 20")
    assert "nearest: sensor.pixel_um of IMX4" in what  # there are two of 9 um
    assert remedy == "Relax it, or widen the design space."


def test_constraints_that_exclude_one_another_are_told(toys):
    bounds = {"hfov_deg": {"min": 100}, "pixels_per_deg": {"min": 60}, "megapixels": {"max": 1}}
    ((where, what, _),) = faults_of(toys, constraints=bounds)
    assert where == "recipe.constraints"
    assert "keeps all constraints; nearest: " in what


def test_a_corner_of_the_space_that_keeps_the_constraints_is_found(toys):
    bounds = {"hfov_deg": {"min": 100, "max": 100.5}, "sensor.pixel_um": {"min": 8.9}}
    plan = make_plan(recipe(constraints=bounds), toys)  # 1 sensor of 43, 0.03 mm of focal length
    assert infeasible(plan) is None


def test_lens_and_sensor_must_fit_without_the_recipe_saying_so(toys):
    plan = make_plan(recipe(design=LENS_AND_SENSOR, constraints={}), toys)
    small = values_of(plan, "OpenMV IR Lens 2.8 mm", "IMX432")
    (breach,) = plan.breaches(small, derived(plan, small))
    assert breach.quantity == "image_circle_margin_mm"
    assert breach.amount == pytest.approx(17.56 - 6.0, abs=0.01)
    assert "must cover the sensor" in breach.sentence
    assert plan.broken(small, derived(plan, small)) == {"image_circle_margin_mm": breach.amount}
    relaxed = make_plan(
        recipe(design=LENS_AND_SENSOR, constraints={"image_circle_margin_mm": {"min": -20}}), toys
    )
    assert relaxed.broken(small, derived(plan, small)) == {}


def test_a_lens_must_open_as_far_as_every_scenario(toys):
    scenario = [{"name": "day", "f_number": 4}, {"name": "night", "f_number": 1.4}]
    plan = make_plan(recipe(design=LENS_AND_SENSOR, constraints={}, scenario=scenario), toys)
    values = values_of(plan, "OpenMV IR Lens 2.8 mm", "IMX219")
    (breach,) = plan.breaches(values, derived(plan, values))
    assert (breach.quantity, breach.amount) == ("f_number_min", pytest.approx(0.6))
    assert breach.sentence.endswith("above the largest allowed value 1.4 (exposures are taken at f/1.4)")
    assert plan.breaches({**values, "scenario.night.f_number": 2.8}, derived(plan, values)) == ()


def test_what_nobody_states_of_one_camera_is_named(toys):
    bounds = {"lens.mass_g": {"max": 100}, "sensor.power_w": {"max": 4}}
    plan = make_plan(recipe(design=LENS_AND_SENSOR, constraints=bounds), toys)
    values = values_of(plan, "Fujinon HF16SA-1", "AR0134")
    assert plan.unknown(values, derived(plan, values)) == (
        "lens.mass_g",
        "sensor.power_w",
        "image_circle_margin_mm",
    )
    notes = " ".join(notes_on_camera(plan, values))
    assert "Not published: the image circle of Fujinon HF16SA-1; ask for one of at least 6.0 mm" in notes


def test_a_product_with_a_lens_of_its_own_leaves_none_to_design(toys):
    compare = {"cameras": ["flea3", "basler_dart"], "evaluations": 1}
    bounds = {"sensor.shutter": {"is": "global"}, "lens.mount": {"any_of": ["M12"], "unknown": "refuse"}}
    plan = make_plan(recipe(design=LENS_AND_SENSOR, constraints=bounds, compare=compare), toys)
    assert [plan.free_of(camera).names for camera in plan.cameras] == [("pitch_deg",)] * 2
    assert inadmissible(plan) == {"flea3": "sensor.shutter of IMX172 is rolling, not global"}
    notes = list(notes_on_constraints(plan))
    assert notes[-1].startswith("FLIR Flea3 (flea3) breaks a constraint: sensor.shutter of IMX172")


def test_objectives_are_quantities_of_the_recipe(toys):
    aims = [{"quantity": "fitness", "aim": "max"}, {"quantity": "sensor.power_w", "aim": "min"}]
    plan = make_plan(recipe(objectives=[*aims, {"quantity": "megapixels", "aim": "max"}]), toys)
    assert [(o.name, o.unit, o.aim) for o in plan.objectives] == [
        ("fitness", "1", "max"),
        ("sensor.power_w", "W", "min"),
        ("megapixels", "Mpx", "max"),
    ]


@pytest.mark.parametrize(
    ("objectives", "what"),
    [
        (
            ["fitness", "sensor.powr_w"],
            "there is no derived quantity, column of a part, or score 'sensor.powr_w'",
        ),
        (["fitness", "sensor.shutter"], "sensor.shutter is text, of which there is no more or less"),
        (["fitness", "fitness"], "fitness stands twice"),
        (["fitness"], "there is one objective"),
    ],
)
def test_objectives_that_are_none_are_told(toys, objectives, what):
    given = [{"quantity": name, "aim": "max"} for name in objectives]
    assert [found for _, found, _ in faults_of(toys, objectives=given)] == [what]


def test_a_rig_that_fails_to_say_its_notes_costs_no_result(toys, monkeypatch):
    plan = make_plan(recipe(), toys)

    def fails(self, variables):
        raise ZeroDivisionError("no lens")

    monkeypatch.setattr(plan.rig.cls, "notes", fails)
    values = plan.space.decode([gene.lower for gene in plan.space.genes]).as_dict()
    *_, note = notes_on_camera(plan, values)
    assert note == "rig.monocular of tacos-framework has notes on this camera, but fails to say them: no lens"


def test_who_buys_a_part_is_told_what_to_ask_its_maker(toys):
    plan = make_plan(recipe(design=LENS_AND_SENSOR, constraints={}), toys)
    said = list(notes_on_camera(plan, values_of(plan, "OpenMV IR Lens 3.6 mm", "IMX273")))
    assert any(
        note.startswith("OpenMV IR Lens 3.6 mm: Made without an infra-red cut filter") for note in said
    )
    (asked,) = (note for note in said if "Ask the maker" in note and "OpenMV" in note)
    assert "Ask the maker for image circle [mm], of grade 'derived' here (Diagonal of the largest" in asked
    of_a_list = list(notes_on_camera(plan, values_of(plan, "AICO AC13B03618MM", "IMX273")))
    assert any("f number min" in note and "'hobby list'" in note for note in of_a_list)
