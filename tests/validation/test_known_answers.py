"""``tacos-run known_answers``: what the industry has, what a study says, how the two are held together."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from toy_study import merged, toy_recipe

from tacos_framework import ProcedureRecipe, UserError, load_recipe, run
from tacos_framework.plan import make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Use
from tacos_validation import harness
from tacos_validation.known_answers.agreement import held, middle, share_in_class
from tacos_validation.known_answers.industry import (
    POINTS,
    SHIPPED,
    industry_answer,
    read_systems,
)

HEADING = "job,system,width_px,height_px,pixel_um,shutter,colour,hfov_deg,baseline_mm"
COLUMNS = HEADING.split(",")


def system(name: str, **cells: Any) -> dict[str, str]:
    return (
        dict.fromkeys(COLUMNS, "") | {"job": "seeing", "system": name} | {k: str(v) for k, v in cells.items()}
    )


@pytest.mark.parametrize(
    ("cell", "degrees"),
    [
        ("93.1", 93.1),
        ("about 100 diagonal", 100),
        ("more than 200", 200),
        ("210 (lens, direction not stated)", 210),
        ("fisheye; model reaches 183 at the frame edge", 183),
        ("fisheye (567 px near the centre)", None),
        ("fisheye", None),
        ("", None),
    ],
)
def test_a_field_of_view_is_read_where_a_source_states_one(cell: str, degrees: float | None) -> None:
    found = industry_answer("field", [system("a", hfov_deg=cell)])
    if degrees is None:
        assert found is None
    else:
        assert found is not None
        assert (found.within.min, found.within.max) == pytest.approx((degrees / 1.25, degrees * 1.25))


@given(st.lists(st.floats(0.5, 12), min_size=1, max_size=8))
def test_every_system_is_of_the_class_of_its_job(pitches: list[float]) -> None:
    systems = [system(str(i), pixel_um=repr(pitch)) for i, pitch in enumerate(pitches)]
    found = industry_answer("pixel", systems)
    assert found is not None
    assert all(found.within.breach(pitch) is None for pitch in pitches)
    assert found.within.breach(max(pitches) * 1.3) is not None
    assert found.within.breach(min(pitches) / 1.3) is not None


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (["global", "global (in all cases)", "global", "rolling"], "global"),
        (["global", "rolling", "rolling"], None),
        (["", ""], None),
    ],
)
def test_a_word_is_the_industrys_where_three_quarters_have_it(words: list[str], answer: str | None) -> None:
    found = industry_answer("shutter", [system(str(i), shutter=word) for i, word in enumerate(words)])
    assert (found and found.within.any_of) == (answer and (answer,))


def test_the_table_that_ships_has_every_job_of_the_recipe_and_a_source_for_every_number() -> None:
    systems = read_systems(SHIPPED)
    recipe = load_recipe("known_answers")
    for job in recipe.settings["jobs"].values():
        own = [row for row in systems if row["job"] in job["systems"]]
        assert own
        assert any(industry_answer(point, own) for point in job["points"])
    stating = [row for row in systems if any(row[c] for point in POINTS.values() for c in point.columns)]
    assert all(row["source"] for row in stating)


def test_a_table_without_its_columns_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("job,system,shutter\n")
    with pytest.raises(UserError, match="no column colour, pixel_um"):
        read_systems(path)


def test_the_middle_of_weighted_numbers_and_words() -> None:
    assert middle([(1.0, 0.2), (5.0, 0.3), (2.0, 0.5)]) == 2
    assert middle([("mono", 0.4), ("colour", 0.35), ("mono", 0.25), (None, 9)]) == "mono"
    assert middle([(None, 1.0)]) is None


RESULT = {
    "ranking": [
        {"camera": {"sensor": {"name": "A", "shutter": "global"}}},
        {"camera": {"sensor": {"name": "B", "shutter": "rolling"}}},
    ],
    "equivalent": {
        "optimal": [
            {"camera": {"sensor": "A"}, "derived": {"hfov_deg": 150.0}, "probability": 0.7},
            {"camera": {"sensor": "B"}, "derived": {"hfov_deg": 60.0}, "probability": 0.3},
        ]
    },
}


@pytest.fixture(scope="module")
def toy_plan(toys):
    return make_plan(toy_recipe(), toys)


@pytest.mark.parametrize(
    ("point", "cell", "probability", "agrees"),
    [("shutter", "global", 0.7, True), ("shutter", "rolling", 0.3, False), ("field", "60", 0.3, False)],
)
def test_a_class_is_as_probable_as_the_draws_whose_best_camera_is_in_it(
    toy_plan, point, cell, probability, agrees
) -> None:
    answer = industry_answer(point, [system("a", **{POINTS[point].columns[0]: cell})])
    found = held("seeing", answer, RESULT, toy_plan)
    assert (found.probability, found.agrees) == (probability, agrees)


def test_a_study_that_names_no_winner_agrees_with_nobody_and_says_why(toy_plan) -> None:
    answer = industry_answer("field", [system("a", hfov_deg=60)])
    found = held("seeing", answer, {"decision_absent": "All 4 cameras of the search score zero."}, toy_plan)
    assert (found.study, found.probability, found.agrees) == (None, None, False)
    assert found.as_data()["why"] == "All 4 cameras of the search score zero."


def test_chance_is_the_share_of_the_space(toy_plan) -> None:
    """Of focal lengths spread evenly over .5 to 5 mm before 1.6 mm of sensor."""
    answer = industry_answer("field", [system("a", hfov_deg=40)])
    focal_mm = np.linspace(0.5, 5, 100_000)
    field_deg = np.degrees(2 * np.arctan(0.8 / focal_mm))
    share = float(np.mean((field_deg >= 32) & (field_deg <= 50)))
    assert share_in_class(toy_plan, answer.within) == pytest.approx(share, abs=0.01)


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    """A toy whose best camera has 90 degrees."""
    path = tmp_path_factory.mktemp("study") / "toy.yaml"
    searched = {"optimizer": {"use": "optimizer.physical-gp", "evaluations": 8}}
    path.write_text(yaml.safe_dump(toy_recipe(study={"episodes": 3}).as_data() | searched))
    return path


@pytest.fixture(scope="module")
def table(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("table") / "systems.csv"
    path.write_text(f"{HEADING}\nseeing,a,,,,,,90,\nseeing,b,,,,,,100,\nfar,c,,,,,,20,\n")
    return path


def asked(study: Path, table: Path, **settings: Any) -> ProcedureRecipe:
    job = {"study": str(study), "points": ["field", "shutter"]}
    base = {
        "data": str(table),
        "evaluations": 10,
        "jobs": {"wide": {**job, "systems": ["seeing"]}, "narrow": {**job, "systems": ["far"]}},
    }
    recipe = merged(base, settings)
    return ProcedureRecipe("procedure.known-answers", recipe, name="k", executor=Use(use="executor.local"))


@pytest.fixture(scope="module")
def with_analysis():
    import toy_plugin

    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    return plugins


def test_jobs_are_run_held_and_kept(study, table, with_analysis, tmp_path, monkeypatch) -> None:
    out = tmp_path / "out"
    result = run(asked(study, table), out=out, plugins=with_analysis)
    wide, narrow = result["jobs"]
    assert (wide["job"], wide["point"], wide["agrees"]) == ("wide", "field", True)
    assert wide["probability"] > 0.8 > wide["chance"] + 0.3, "a toy of 90 degrees is told from others"
    assert (narrow["agrees"], narrow["probability"] < 0.2) == (False, True)
    assert result["agreement"] == 0.5
    assert result["not_stated"] == {"wide": ["shutter"], "narrow": ["shutter"]}
    assert "1 of 2 points agree" in result["summary"]
    assert "P(industry&#39;s class)" in (out / "report.html").read_text()

    monkeypatch.setattr(harness, "run", lambda *_, **__: pytest.fail("a job that is done was run again"))
    assert run(asked(study, table), out=out, plugins=with_analysis, resume=True)["jobs"] == result["jobs"]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"jobs": {"wide": {"systems": ["seing"]}}}, "Did you mean 'seeing'"),
        ({"jobs": {"wide": {"leave_out": {"z": "no reason"}}}}, "no system 'z'"),
        ({"jobs": {"wide": {"study": "noise_over_gain"}}}, "is no study"),
        ({"jobs": {"wide": {"change": {"nodes.width.use": "task.none"}}}}, "jobs.wide"),
        ({"jobs": {"wide": {"points": ["shutter"]}, "narrow": {"points": ["shutter"]}}}, "state no point"),
    ],
)
def test_what_cannot_be_held_is_said_before_anything_runs(
    study, table, toys, tmp_path, settings, said
) -> None:
    with pytest.raises(UserError, match=said):
        run(asked(study, table, **settings), out=tmp_path / "out", plugins=toys)
    assert not (tmp_path / "out" / "studies").exists()
