"""The table of generations, and what becomes of a study when it cannot be written."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
import tacos_framework as tacos

from tacos_example.generation_log import NAME, GenerationLog

RECIPE = Path(__file__).parents[1] / "recipes" / "find_the_board.yaml"


def evaluation(fitness: float | None) -> tacos.Evaluation:
    return tacos.Evaluation(
        {"pitch_deg": 1.0}, fitness=fitness, failed="too dark" if fitness is None else None
    )


def lines(folder: Path) -> list[list[str]]:
    with (folder / NAME).open(newline="") as file:
        return list(csv.reader(file))[1:]


def test_each_generation_is_a_line(tmp_path: Path) -> None:
    log = GenerationLog()
    log.tacos_study_started(recipe=None, out=tmp_path)
    log.tacos_generation_finished(generation=0, evaluated=[evaluation(None)], best=None)
    log.tacos_generation_finished(1, [evaluation(0.5), evaluation(0.25)], evaluation(0.5))
    assert lines(tmp_path) == [["0", "1", "1", "", ""], ["1", "2", "0", "0.5", "0.5"]]


def test_generations_that_are_made_once_more_are_replaced(tmp_path: Path) -> None:
    for fitness in (0.5, 0.75):
        log = GenerationLog()
        log.tacos_study_started(recipe=None, out=tmp_path)
        log.tacos_generation_finished(0, [evaluation(fitness)], evaluation(fitness))
    assert lines(tmp_path) == [["0", "1", "0", "0.75", "0.75"]]


def test_installed_it_observes_every_study(tmp_path: Path) -> None:
    tacos.run(tacos.load_recipe(RECIPE, {"executor": {"use": "executor.local"}}), out=tmp_path / "run")
    assert [line[:2] for line in lines(tmp_path / "run")] == [["0", "3"], ["1", "3"]]


def test_a_study_goes_on_without_it_when_it_cannot_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(self: GenerationLog, file: Path, before: int) -> list[dict[str, str]]:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(GenerationLog, "_lines", full)
    local = {"executor": {"use": "executor.local"}}
    result = tacos.run(tacos.load_recipe(RECIPE, local), out=tmp_path / "run", report=False)
    assert result["best"]["scores"]["board.found_ratio"] > 0.5
    warning = "the observer generation-log of tacos-example-plugin is switched off"
    assert caplog.text.count(warning) == 1
