"""How studies end: with a verdict, or with a sentence that says why there is none and what to do."""

from __future__ import annotations

import json
import math

import pytest
import toy_plugin
from toy_study import comparable, run, toy_recipe

import tacos_decision.plugin
from tacos_decision import StudyResult, read_result
from tacos_decision.tables import TABLES
from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plan import make_plan
from tests.decision.recorded import from_catalog, with_toys

SMALL = {
    "optimizer": {"population": 4, "keep": 1, "parents": 2, "generations": 2},
    "compare": {"cameras": ["flea3"], "evaluations": 2},
    "test": {"episodes": 8},
}
"""A study that ends with a verdict within a second."""


def small(**sections):
    return from_catalog(**{**SMALL, **sections})


class Analysis:
    """Answers with these keys, or raises."""

    def __init__(self, answer):
        self.answer = answer

    @hookimpl
    def tacos_analyse_study(self, record):
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def test_a_study_decides_and_its_result_can_be_read(tmp_path):
    plugins = with_toys(tacos_decision.plugin)
    result = run(small(study={"renew_episodes": "each_generation"}), plugins, tmp_path / "out")
    decision = result["decision"]
    assert decision["verdict"] in ("better", "worse", "equivalent")
    assert decision["against"] == "flea3"
    assert decision["interval"][0] <= decision["difference"] <= decision["interval"][1]
    assert decision["confidence"] == 0.95
    assert (decision["margin"], decision["margins"]) == (0.01, {"width.closeness": 0.01})
    assert "8 unseen scenes" in decision["sentence"]
    assert "degenerate" not in result
    read = read_result(tmp_path / "out")
    assert read.decision == decision
    ranking = read.rows("ranking")
    assert ranking[0]["part"] == result["ranking"][0]["part"]
    assert {"low", "high", "p_better.flea3", "focal_length_mm"} <= set(ranking[0])
    assert [r["variable"] for r in read.rows("importance")] == [r["variable"] for r in result["importance"]]
    assert read.rows("comparisons")[0]["against"] == "flea3"
    assert {"variable", "value", "mean", "low", "high"} == set(read.rows("curves")[0])
    assert read.rows("front") == []
    assert {row["camera"]: row["fitness"] for row in read.rows("test")} == {
        name: scores["fitness"] for name, scores in result["test"].items()
    }
    searched = read.rows("candidates")
    assert {row["product"] for row in searched} == {None, "flea3"}
    assert max(row["fitness"] for row in searched if row["product"] is None) > 0
    scenes = read.rows("episodes")
    assert {row["key"] for row in scenes} == {row["key"] for row in searched if row["failed"] is None}
    assert all("width.closeness" in row for row in scenes)
    assert repr(read).startswith("<result of 'toy': On 8 unseen scenes")
    with pytest.raises(UserError, match="no table 'rankin'"):
        read.frame("rankin")


@pytest.mark.parametrize("table", TABLES.rows_of)
def test_tables_are_data_frames_where_pandas_is_installed(table):
    pandas = pytest.importorskip("pandas")
    ranked = {
        "part": "A",
        "fitness": 1.0,
        "ci": [0.9, 1.1],
        "camera": {},
        "p_better": {"b": 1.0},
        "unknown": [],
    }
    frame = getattr(StudyResult({"ranking": [ranked]}), table)()
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) == (table == "ranking")


def test_several_scenarios_and_tasks_that_learn_are_analysed_too(tmp_path):
    scenarios = [{"name": "day", "illumination_lux": 100}, {"name": "night", "illumination_lux": 1}]
    result = run(
        toy_recipe(
            scenario=scenarios,
            study={"scenarios": "worst", "episodes": 2},
            test={"episodes": 6},
            nodes={
                "learner": {
                    "use": "task.toy-learner",
                    "in": {"frames": "frames"},
                    "train": {"weights": "shared"},
                }
            },
            fitness=[
                {"score": "width.closeness", "weight": 1},
                {"score": "learner.knowledge", "weight": 0.01},
            ],
        ),
        with_toys(tacos_decision.plugin),
        tmp_path / "out",
    )
    assert result["ranking"][0]["part"] == "designed"  # there is no catalog: the cameras of the study
    assert {row["variable"] for row in result["importance"]} == {"focal_length_mm", "pitch_deg"}
    assert result["equivalent"]["parts"] == []
    assert result["decision"] is None
    assert "names no camera to compare" in result["decision_absent"]


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ({"test": {"episodes": 1, "most_episodes": 1}}, "a single scene"),
        ({"nodes": {"width": {"fail_above_deg": 0.001}}}, "No camera could be scored"),
    ],
)
def test_where_there_is_no_winner_none_is_named(tmp_path, sections, said):
    result = run(small(**sections), with_toys(tacos_decision.plugin), tmp_path / "out")
    assert said in result["degenerate"]
    assert result["decision"] is None
    assert result["decision_absent"] == result["degenerate"]
    assert "ranking" not in result


def test_where_nothing_is_seen_no_winner_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(toy_plugin.WidthScorer, "scores", lambda self: {"closeness": 0.0, "brightness": 0.0})
    result = run(small(), with_toys(tacos_decision.plugin), tmp_path / "out")
    assert "score zero" in result["degenerate"]
    assert result["decision"] is None


def test_weights_that_are_all_zero_are_refused(toys):
    with pytest.raises(UserError, match="all weights are 0"):
        make_plan(small(fitness=[{"score": "width.closeness", "weight": 0}]), toys)


def test_equal_scores_name_no_winner(tmp_path, monkeypatch):
    monkeypatch.setattr(toy_plugin.WidthScorer, "scores", lambda self: {"closeness": 0.5, "brightness": 1.0})
    result = run(small(), with_toys(tacos_decision.plugin), tmp_path / "out")
    assert "have the same fitness, 0.5" in result["degenerate"]
    assert result["decision"] is None


def test_a_score_that_is_the_same_for_all_cameras_is_told_to_decide_nothing(tmp_path, monkeypatch):
    scores = toy_plugin.WidthScorer.scores
    monkeypatch.setattr(toy_plugin.WidthScorer, "scores", lambda self: {**scores(self), "brightness": 1.0})
    terms = [{"score": "width.closeness", "weight": 1}, {"score": "width.brightness", "weight": 2}]
    result = run(small(fitness=terms), with_toys(tacos_decision.plugin), tmp_path / "out")
    (note,) = (note for note in result["notes"] if "the cameras of the test:" in note)
    assert "width.brightness (at 1, 0 % of its variance)" in note
    assert result["scores"]["width.brightness"] == {"share_of_variance": 0.0, "full": True}


def test_without_test_scenes_it_is_said_what_to_add(tmp_path):
    recipe = small().model_copy(update={"test": None})
    result = run(recipe, with_toys(tacos_decision.plugin), tmp_path / "out")
    assert (result["decision"], result["comparisons"]) == (None, [])
    assert "Add test:" in result["decision_absent"]


@pytest.mark.parametrize("optimizer", [{}, {"use": "optimizer.physical-gp", "evaluations": 6}])
@pytest.mark.parametrize(
    ("constraint", "said"),
    [
        ({"megapixels": {"max": 5}}, "megapixels is"),
        ({"sensor.shutter": {"is": "global"}}, "sensor.shutter of IMX172 is rolling, not global"),
    ],
)
def test_a_product_that_breaks_a_constraint_is_shown_with_the_reason(tmp_path, optimizer, constraint, said):
    recipe = small(constraints=constraint)
    if optimizer:
        recipe = small(constraints=constraint).model_copy(
            update={"optimizer": type(recipe.optimizer).model_validate(optimizer)}
        )
    result = run(recipe, with_toys(tacos_decision.plugin), tmp_path / "out")
    (shown,) = result["comparisons"]
    assert (shown["against"], shown["verdict"]) == ("flea3", "not admissible")
    assert said in shown["why"]
    assert result["decision"] is None


def test_a_part_left_out_names_the_constraints_it_breaks_and_no_others(tmp_path):
    recipe = small(constraints={"sensor.shutter": {"is": "global"}, "sensor.pixel_um": {"max": 5}})
    result = run(recipe, with_toys(tacos_decision.plugin), tmp_path / "out")
    why = {row["part"]: row["why"] for row in result["ranking_left_out"]}
    assert why["IMX172"] == "ruled out by the constraint on sensor.shutter"
    assert why["IMX432"] == "ruled out by the constraint on sensor.pixel_um"
    assert all(0 <= row["first_order"] <= 1 and 0 <= row["total"] <= 1 for row in result["importance"])


def test_a_study_that_is_broken_off_during_its_test_resumes_to_the_same_verdict(tmp_path, monkeypatch):
    recipe = small(test={"episodes": 4, "most_episodes": 12})
    before = toy_plugin.WidthTask.begun
    whole = run(recipe, with_toys(), tmp_path / "whole")
    episodes = toy_plugin.WidthTask.begun - before
    monkeypatch.setattr(toy_plugin.WidthTask, "interrupt_at", toy_plugin.WidthTask.begun + episodes - 9)
    stopped = run(recipe, with_toys(), tmp_path / "out")
    assert "decision" not in stopped
    assert "interrupted" in stopped["decision_absent"]
    monkeypatch.setattr(toy_plugin.WidthTask, "interrupt_at", None)
    resumed = run(recipe, with_toys(), tmp_path / "out", resume=True)
    assert comparable(resumed) == comparable(whole)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (ZeroDivisionError("an analysis of a stranger"), "an analysis of a stranger"),
        ({"mine": math.nan}, "ValueError"),
        ({"mine": object()}, "TypeError"),
        ([1, 2], "keys and values are expected"),
        ({"best": None}, "best is left out"),
    ],
)
def test_an_analysis_that_cannot_be_used_is_left_out_with_a_note(tmp_path, capsys, answer, said):
    plain = run(small(), with_toys(), tmp_path / "plain")
    result = run(small(), with_toys(Analysis(answer), Analysis({"other": [1.5]})), tmp_path / "out")
    assert result["other"] == [1.5]
    assert said in result["notes"][-1]
    assert result["best"] == plain["best"]
    assert "mine" not in result
    assert json.loads((tmp_path / "out" / "result.json").read_text())["other"] == [1.5]
    capsys.readouterr()


def test_of_two_analyses_that_give_one_key_the_first_keeps_it(tmp_path, capsys):
    result = run(small(), with_toys(Analysis({"mine": 1}), Analysis({"mine": 2})), tmp_path / "out")
    assert result["mine"] == 1
    assert "another plugin answers" in result["notes"][-1]
    capsys.readouterr()


def test_more_scenes_than_the_most_are_refused():
    with pytest.raises(ValueError, match="fewer than episodes, 8"):
        small(test={"most_episodes": 7})


@pytest.mark.parametrize("text", ["", "[]", "{}"])
def test_what_is_no_result_is_refused(tmp_path, text):
    (tmp_path / "result.json").write_text(text)
    with pytest.raises(UserError, match=r"result\.json"):
        read_result(tmp_path)


def test_a_result_shows_itself_in_notebooks() -> None:
    data = {
        "cameras": {"designed": {"title": "Designed"}, "a": {"title": "A & B"}, "failed": {"title": "C"}},
        "test": {"designed": {"fitness": 1.25}, "a": {"fitness": 2.5}, "failed": {"fitness": None}},
        "decision": {"sentence": "A is better."},
    }
    html = StudyResult(data)._repr_html_()
    assert html.startswith("<p>A is better.</p>")
    assert (
        html.index("A &amp; B</td><td>2.5") < html.index("Designed</td><td>1.25") < html.index("C</td><td>")
    )


def test_a_folder_without_a_result_is_called_that(tmp_path):
    with pytest.raises(UserError, match=r"there is no result\.json here"):
        read_result(tmp_path / "nothere")
