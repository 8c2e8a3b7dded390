"""Studies in one table: what is looked up, what is marked, what is refused, going on with a broken run."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import toy_plugin
import yaml
from toy_study import FROM_CATALOG

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.recipe import Use
from tacos_framework.testing import ProcedureConformance
from tacos_framework.testing.procedure import InThisProcess
from tacos_validation.studies_table.findings import RowResult, StudyRun, SummaryCell, findings, look_up
from tacos_validation.studies_table.pages import TableOutcome, summary
from tacos_validation.studies_table.settings import SummaryColumn, TableRow
from tacos_validation.studies_table.table import StudiesTable

PROBLEM = {
    **FROM_CATALOG,
    "design": {"focal_length_mm": {"between": [1, 20]}, "sensor": {"from": "image_sensors"}},
    "constraints": {},
    "optimizer": {"use": "optimizer.genetic", "population": 4, "keep": 1, "parents": 2, "generations": 3},
    "compare": {"cameras": ["flea3"]},
}
SETTINGS: dict[str, Any] = {
    "studies": {
        "genetic": {},
        "random": {"change": {"optimizer": {"use": "optimizer.random", "evaluations": 6}}},
        "ghost": {"change": {"optimizer": {"use": "optimizer.ghost"}}},
    },
    "optional": ["ghost"],
    "columns": [
        {"head": "Focal length", "value": "camera.focal_length_mm", "unit": "mm"},
        {"head": "Sensor", "value": "camera.sensor.name"},
        {"head": "HFOV", "value": "derived.hfov_deg", "unit": "deg", "digits": 2},
        {"head": "Closeness", "value": "test.width.closeness", "better": "higher"},
    ],
    "rows": [
        {"title": "Flea3", "study": "genetic", "camera": "flea3", "published": {"Focal length": 3.6}},
        {"title": "Random", "study": "random"},
        {"title": "Haunted", "study": "ghost"},
        {"title": "Ours", "study": "genetic", "published": {"Closeness": 0.9, "Sensor": "IMX172"}},
    ],
    "published_in": "a paper, Table 7",
    "differs": ["The toys are not the paper's."],
}


@pytest.fixture(scope="module")
def problem(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("problem") / "toy.yaml"
    path.write_text(yaml.safe_dump(PROBLEM))
    return path


def asked(path: Path, **settings: Any) -> ProcedureRecipe:
    given = {"problem": str(path), **SETTINGS, **settings}
    return ProcedureRecipe("procedure.studies-table", given, name="t", executor=Use(use="executor.local"))


@pytest.fixture(scope="module")
def tabled(problem, reporting_toys, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    """A table that several tests look at: its result and its folder."""
    out = tmp_path_factory.mktemp("tabled") / "out"
    return run(asked(problem, seeds=2), out=out, plugins=reporting_toys), out


@pytest.fixture(scope="module")
def unbroken(problem, toys, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    """A table of one seed that nothing happened to: its result and its folder."""
    out = tmp_path_factory.mktemp("unbroken") / "out"
    return run(asked(problem), out=out, plugins=toys), out


def test_the_table_has_the_figures_of_the_studies(tabled):
    result, out = tabled
    assert [row["title"] for row in result["table"]] == ["Flea3", "Random", "Ours"]
    assert {(run["study"], run["seed"]) for run in result["studies"]} == {
        ("genetic", 3),
        ("random", 3),
        ("genetic", 4),
        ("random", 4),
    }
    ours = result["table"][2]
    closeness = []
    for seed in (3, 4):
        study = json.loads((out / f"studies/genetic_{seed}/result.json").read_text())
        assert (out / f"studies/genetic_{seed}/report.html").exists()
        closeness.append(study["test"]["designed"]["width.closeness"])
    assert ours["ours"]["Closeness"] == pytest.approx(sum(closeness) / 2)
    assert ours["published"] == {"Closeness": 0.9, "Sensor": "IMX172"}
    flea = result["table"][0]["ours"]
    assert flea["Focal length"] == 3.6
    assert flea["Sensor"] == "IMX172"
    assert flea["HFOV"] == pytest.approx(81.5, abs=0.1)


def test_seeds_make_studies_differ_and_the_table_keeps_their_range(tabled):
    _, out = tabled
    lines = list(csv.DictReader((out / "table.csv").read_text().splitlines()))
    assert len(lines) == 3 * 4
    focal = next(each for each in lines if each["row"] == "Random" and each["column"] == "Focal length")
    assert float(focal["lowest"]) < float(focal["median"]) < float(focal["highest"])
    assert focal["runs"] == "2"
    assert focal["unit"] == "mm"


def test_the_report_says_what_differs_and_what_was_left_out(tabled):
    result, out = tabled
    page = (out / "report.html").read_text()
    for said in ("a paper, Table 7", "The toys are not the paper", "ghost was left out", "IMX172", "(best)"):
        assert said in page
    assert "Haunted" not in page
    for figure in ("3.6", "IMX172", "0.9"):
        assert f"<small>{figure}</small></td>" in page  # published, below ours, and nowhere else
    assert page.count("<small>") == 3
    assert 'src="http' not in page
    assert result["summary"].startswith("3 cameras side by side")  # Random finds what Ours does
    assert any(note.startswith("ghost was left out") for note in result["comparison_notes"])


def test_a_broken_run_keeps_the_studies_that_are_done(unbroken, problem, toys, tmp_path):
    whole, folder = unbroken
    out = shutil.copytree(folder, tmp_path / "out")
    kept = (out / "studies/genetic_3/result.json").read_bytes()
    (out / "studies/random_3/result.json").unlink()
    before = toy_plugin.WidthTask.begun
    again = run(asked(problem), out=out, plugins=toys, resume=True)
    assert again["table"] == whole["table"]
    assert (out / "studies/genetic_3/result.json").read_bytes() == kept
    assert toy_plugin.WidthTask.begun - before < 6  # tested anew at most, not searched


class BrokenOff(InThisProcess):
    """Ctrl-C while the first candidates are evaluated."""

    def map(self, evaluate, jobs):
        raise KeyboardInterrupt


def test_ctrl_c_ends_all_of_it_not_one_study(unbroken, problem, toys, tmp_path):
    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        run(asked(problem), out=out, plugins=toys, executor=BrokenOff())
    assert [folder.name for folder in (out / "studies").iterdir()] == ["genetic_3"]
    again = run(asked(problem), out=out, plugins=toys, resume=True)
    assert again["table"] == unbroken[0]["table"]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"optional": []}, "studies.ghost"),
        ({"optional": ["gost"]}, "Did you mean 'ghost'?"),
        ({"rows": [{"title": "a", "study": "genetics"}]}, "Did you mean 'genetic'?"),
        ({"rows": [{"title": "a", "study": "genetic", "camera": "flea9"}]}, "has no camera 'flea9'"),
        (
            {"rows": [{"title": "a", "study": "genetic", "published": {"Closenes": 1}}]},
            "Did you mean 'Closeness'?",
        ),
        ({"columns": [{"head": "a", "value": "score.b"}]}, "score.b"),
        ({"columns": SETTINGS["columns"] * 2}, "different heads"),
        ({"studies": {"a/b": {}}, "optional": []}, "part of a folder's"),
        ({"change": {"test": None}}, "no test scenes"),
        ({"problem": "optimizers_compared"}, "is no study"),
    ],
)
def test_what_cannot_be_tabled_is_refused_before_anything_runs(problem, toys, tmp_path, settings, said):
    with pytest.raises(UserError) as raised:
        run(asked(problem, **settings), out=tmp_path / "out", plugins=toys)
    assert said in str(raised.value)
    assert not (tmp_path / "out" / "studies").exists()


def result_of(closeness: float | None) -> Mapping[str, Any]:
    scores = {} if closeness is None else {"w.c": closeness}
    return {
        "cameras": {"designed": {"camera": {"part": {"name": "P"}}, "derived": {}}},
        "test": {"designed": scores},
    }


def test_the_best_of_a_column_stands_out_where_there_is_one():
    runs = [
        StudyRun("a", 0, result_of(0.2), ()),
        StudyRun("b", 0, result_of(0.1), ()),
        StudyRun("c", 0, result_of(None), ()),
    ]
    rows = [TableRow(title=name, study=name) for name in ("a", "b", "c", "gone")]
    for better, expected in (("lower", "b"), ("higher", "a"), (None, None)):
        column = SummaryColumn(head="c", value="test.w.c", better=better)
        found = findings(rows, [column], runs)
        assert [row.title for row in found] == ["a", "b", "c"]
        assert [row.title for row in found if row.cells[0].best] == ([expected] if expected else [])
        assert found[2].cells[0].values == ()


def test_names_go_on_inside_parts():
    assert look_up(result_of(0.5), "designed", "camera.part.name") == "P"
    assert look_up(result_of(0.5), "designed", "test.w.c") == 0.5
    assert look_up(result_of(0.5), "designed", "camera.part.size") is None
    assert look_up(result_of(0.5), "other", "test.w.c") is None


def test_the_headline_names_a_camera_that_alone_is_best():
    config = StudiesTable.Config.model_validate(
        {
            **SETTINGS,
            "problem": "toy",
            "columns": [
                {"head": "Seen", "value": "test.seen", "better": "higher"},
                {"head": "Error", "value": "test.error", "better": "lower"},
            ],
            "rows": [{"title": title, "study": "genetic"} for title in ("One", "Other")],
        }
    )

    def rows(*errors: float) -> tuple[RowResult, ...]:
        best = min(errors)
        return tuple(
            RowResult(
                row.title,
                (SummaryCell((1.0,), None, best=True), SummaryCell((error,), None, best=error == best)),
                1,
            )
            for row, error in zip(config.rows, errors, strict=True)
        )

    def headline(*errors: float) -> str:
        return summary(TableOutcome(config, rows(*errors), (), ())).splitlines()[0]

    assert headline(0.5, 0.25) == "Other has the best error: 0.25"
    assert headline(0.5, 0.5) == "2 cameras side by side"


def test_curves_are_the_best_so_far_over_images():
    lines = [
        {"frames": 10, "best": None},
        {"frames": 10, "best": {"fitness": 0.3}},
        {"frames": 5, "best": {"fitness": 0.4}},
    ]
    assert StudyRun("a", 0, {}, lines).curve == ([20, 25], [0.3, 0.4])


class TestStudiesTable(ProcedureConformance):
    component = StudiesTable
    files = ("report.html", "table.csv")

    @pytest.fixture(autouse=True)
    def _on_a_toy(self, problem, toys):
        self.config = asked(problem).settings  # type: ignore[misc]
        self.plugins = toys

    def comparable(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        studies = [{**each, "seconds": 0} for each in result["studies"]]
        return {**super().comparable(result), "studies": studies}
