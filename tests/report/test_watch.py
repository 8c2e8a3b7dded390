"""``tacos watch``: what a study tells while it runs."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from pathlib import Path

import pytest

from tacos_framework.cli import tacos_main
from tacos_framework.errors import UserError
from tacos_framework.store import Results
from tacos_report.watching.in_words import ranking, state
from tacos_report.watching.running_study import MOST_SHOWN, read_running


def candidate(focal_length_mm: float, fitness: float | None) -> dict[str, object]:
    camera = {"focal_length_mm": focal_length_mm}
    return {"camera": camera, "fitness": fitness, "failed": None if fitness is not None else "too wide"}


def begun(folder: Path, *rounds: list[dict[str, object]]) -> Path:
    (folder / "recipe.yaml").write_text("name: a study <b>of mine</b>\n")
    (folder / "log.txt").write_text("begun\ngeneration 2: best 3\n")
    rows = [{"generation": i, "frames": 10, "candidates": each} for i, each in enumerate(rounds)]
    (folder / "generations.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    return folder


def test_the_best_come_first_and_each_camera_once(tmp_path: Path) -> None:
    first = [candidate(2.0, 1.0), candidate(3.0, 2.0), candidate(9.0, None)]
    again = [candidate(3.0, 2.5), candidate(4.0, -1.0)]
    study = read_running(begun(tmp_path, first, again))
    assert [(t.camera["focal_length_mm"], t.fitness) for t in study.ranking] == [
        (3.0, 2.5),
        (2.0, 1.0),
        (4.0, -1.0),
    ]
    assert ranking(study)[0] == ("1", "a 3\u202fmm lens", "2.5", "2")
    said = state(replace(study, is_running=True), study.written_at_s + 61)
    assert said == "Running; last heard of 1 min 1 s ago. 5 candidates scored, 20 images rendered, 1 failed."


def test_a_run_whose_process_is_gone_is_told_from_one_that_runs(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with Results.create(folder, {"name": "a study"}):
        assert state(read_running(folder), 0.0).startswith("Running; ")
    gone = state(read_running(folder), 0.0)
    assert gone.startswith("Broken off, as no process works on it; ")
    assert gone.endswith("Go on with it by --resume.")


def test_a_long_ranking_is_cut(tmp_path: Path) -> None:
    study = read_running(begun(tmp_path, [candidate(f, f) for f in range(1, 30)]))
    assert len(study.ranking) == MOST_SHOWN


def test_a_line_that_is_being_written_is_left_for_later(tmp_path: Path) -> None:
    folder = begun(tmp_path, [candidate(2.0, 1.0)])
    with (folder / "generations.jsonl").open("a") as file:
        file.write('{"generation": 1, "candi')
    assert len(read_running(folder).tried) == 1


def test_before_the_first_round_it_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "recipe.yaml").write_text("name: new\n")
    assert tacos_main(["watch", str(tmp_path), "--once", "--page"]) == 0
    assert "0 candidates scored" in " ".join(capsys.readouterr().out.split())
    assert "No candidate has been scored yet." in (tmp_path / "watch.html").read_text()


def test_the_page_reloads_while_it_runs_and_rests_once_it_has_ended(tmp_path: Path) -> None:
    folder = begun(tmp_path, [candidate(2.0, 1.0)])
    tacos_main(["watch", str(folder), "--once", "--page", "--every", "3"])
    running = (folder / "watch.html").read_text()
    assert re.search(r'<meta http-equiv="refresh" content="3(\.0)?">', running)
    assert "a study &lt;b&gt;of mine&lt;/b&gt;" in running
    (folder / "result.json").write_text(json.dumps({"stopped": "all 20 generations were evaluated"}))
    tacos_main(["watch", str(folder), "--page"])  # returns, as the study has ended
    ended = (folder / "watch.html").read_text()
    assert 'http-equiv="refresh"' not in ended
    assert "Ended: all 20 generations were evaluated." in ended


def test_a_file_that_goes_meanwhile_is_not_missed(tmp_path: Path) -> None:
    folder = begun(tmp_path, [candidate(2.0, 1.0)])
    (folder / "run.sqlite-wal").symlink_to(folder / "gone")  # listed, and not there any more
    assert len(read_running(folder).tried) == 1


def test_its_own_page_is_no_sign_of_life(tmp_path: Path) -> None:
    folder = begun(tmp_path)
    (folder / "watch.html").write_text("<p>")
    os.utime(folder / "watch.html", (4e9, 4e9))
    assert read_running(folder).written_at_s < 4e9


def test_a_damaged_result_is_a_fault(tmp_path: Path) -> None:
    folder = begun(tmp_path)
    (folder / "result.json").write_text('{"stopped": "all')
    with pytest.raises(UserError, match="the file is damaged"):
        read_running(folder)


def test_a_folder_of_something_else_is_a_fault(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no run has begun here"):
        read_running(tmp_path)
    assert tacos_main(["watch", str(tmp_path / "absent")]) == 2
    begun(tmp_path)
    assert tacos_main(["watch", str(tmp_path), "--every", "0"]) == 2
