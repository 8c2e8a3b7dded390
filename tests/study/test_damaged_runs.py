"""Whatever becomes of the files of a run: it goes on to the same result, or refuses in a sentence."""

from __future__ import annotations

import os
import random
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

from tacos_framework.cli import tacos_main
from tacos_framework.errors import UserError
from tacos_framework.store import Results, read_run_lines
from tacos_framework.store.database import DATABASE, Database
from tacos_framework.store.run import CHECKPOINT
from tacos_framework.study.journal import EVALUATIONS
from tacos_report.verifying import verify

UNCHECKED = (".html", ".txt")


def recipe():
    return toy_recipe(
        **LEARNER,
        optimizer={"population": 3, "keep": 1, "parents": 2, "generations": 2},
        rig={"binning": 200},
        test={"frames": 2, "episodes": 1},
        study={"renew_training": "each_candidate", "train_best": 1},
    )


@pytest.fixture(scope="module")
def runs(toys, tmp_path_factory):
    """A whole run, and one that was interrupted between two checkpoints; and the result of either."""
    folder = tmp_path_factory.mktemp("runs")
    result = comparable(run(recipe(), toys, folder / "whole"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(toy_plugin.WidthTask, "begun", 0)
        patch.setattr(toy_plugin.WidthTask, "interrupt_at", 5)
        run(recipe(), toys, folder / "broken")
    with Database(folder / "broken" / DATABASE, read_only=True) as database:
        assert database.count(EVALUATIONS) > 0
        assert database.count(CHECKPOINT) == 1
    return folder, result


def flipped(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    changed[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data))]


def after_damage(toys, folder: Path, expected) -> str:
    """What a resumed run makes of a damaged folder: ``same`` or ``refused``; anything else is an error."""
    try:
        result = comparable(run(recipe(), toys, folder, resume=True))
    except UserError:
        return "refused"
    assert result == expected
    return "same"


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in range(1, 40))])
@pytest.mark.parametrize("state", ["broken", "whole"])
@pytest.mark.parametrize("damage", [flipped, cut])
def test_a_damaged_file_is_named_and_never_gives_another_result(toys, tmp_path, runs, state, damage, seed):
    folder, expected = runs
    rng = random.Random(f"{seed}{state}{damage.__name__}")
    names = [path.relative_to(folder / state) for path in sorted((folder / state).rglob("*"))]
    for name in (n for n in names if (folder / state / n).is_file() and n.suffix not in UNCHECKED):
        shutil.copytree(folder / state, tmp_path / name.name)
        path = tmp_path / name.name / name
        path.write_bytes(damage(path.read_bytes(), rng))
        checks = {check.name: check for check in verify(tmp_path / name.name)}
        outcome = after_damage(toys, tmp_path / name.name, expected)
        assert checks[str(name)].damage or outcome == "same", name  # a byte of the database that is not used
        assert checks[str(name)].meaning


def test_verify_says_what_is_whole_what_is_damaged_and_what_that_means(tmp_path, runs, capsys):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    assert tacos_main(["verify", str(tmp_path / "run")]) == 0
    assert "ok  run.sqlite" in capsys.readouterr().out
    with (tmp_path / "run" / "result.json").open("a") as file:
        file.write(" ")
    assert tacos_main(["verify", str(tmp_path / "run")]) == 1
    said = capsys.readouterr().out
    assert "BAD result.json: its digest is not the one that the run wrote down" in said
    assert "--resume writes it anew" in said
    assert tacos_main(["verify", str(tmp_path)]) == 2


@pytest.mark.parametrize(
    ("key", "value"),
    [("searches", {}), ("searches", []), ("seconds", "x"), ("weights", {"designed.learner": "../x"})],
)
def test_a_checkpoint_with_a_digest_that_fits_and_strange_content_is_refused(
    toys, tmp_path, runs, key, value
):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    with Database(tmp_path / "run" / DATABASE) as database:
        database.put(CHECKPOINT, 0, {**database.get(CHECKPOINT, 0), key: value})
    with pytest.raises(UserError, match="the file is damaged"):
        run(recipe(), toys, tmp_path / "run", resume=True)


def test_a_named_pipe_in_place_of_a_file_does_not_hang(toys, tmp_path, runs):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    (tmp_path / "run" / DATABASE).unlink()
    os.mkfifo(tmp_path / "run" / DATABASE)
    with pytest.raises(UserError, match="it is a named pipe"):
        run(recipe(), toys, tmp_path / "run", resume=True)


def test_an_entry_that_was_changed_by_another_hand_is_named(tmp_path):
    with Results.create(tmp_path, {"name": "x"}) as results:
        for number in range(3):
            results.append_line("lines.jsonl", {"n": number})
    with closing(sqlite3.connect(tmp_path / DATABASE)) as connection, connection:
        connection.execute("UPDATE entries SET value = '{\"n\": 7}' WHERE kind = 'lines.jsonl' AND key = 1")
    with pytest.raises(UserError, match=r"the digest of lines\.jsonl 1 does not fit its content"):
        Results.resume(tmp_path, {"name": "x"})


def test_lines_that_somebody_changed_are_named_and_written_anew(toys, tmp_path, runs):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    lines = tmp_path / "run" / "generations.jsonl"
    whole = lines.read_bytes()
    lines.write_bytes(whole.replace(b"generation", b"exhibition"))
    (bad,) = (check for check in verify(tmp_path / "run") if check.damage)
    assert (bad.name, bad.damage) == (
        "generations.jsonl",
        "its digest is not the one that the run wrote down",
    )
    run(recipe(), toys, tmp_path / "run", resume=True)
    assert lines.read_bytes() == whole


def test_what_a_killed_run_left_in_the_log_of_its_database_is_read(tmp_path):
    with Results.create(tmp_path / "run", {"name": "x"}) as results:
        results.append_line("lines.jsonl", {"n": 1})
        shutil.copytree(tmp_path / "run", tmp_path / "killed")  # as it lies there at this moment
    assert (tmp_path / "killed" / f"{DATABASE}-wal").stat().st_size
    assert all(check.damage is None for check in verify(tmp_path / "killed") if check.name != "manifest.json")
    assert read_run_lines(tmp_path / "killed" / "lines.jsonl") == [{"n": 1}]


def test_a_finished_run_is_verified_where_nothing_can_be_written(tmp_path, runs, monkeypatch):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    names = sorted(path.name for path in (tmp_path / "run").iterdir())
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert all(check.damage is None for check in verify(tmp_path / "run"))
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == names
