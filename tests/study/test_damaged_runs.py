"""Whatever becomes of the files of a run: it goes on to the same result, or refuses in a sentence."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

from tacos_framework.cli import tacos_main
from tacos_framework.errors import UserError
from tacos_framework.results import Results
from tacos_framework.results.checksums import checked_json, json_with_checksum
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
    assert (folder / "broken" / "journal.jsonl").exists()
    assert (folder / "broken" / "checkpoint.json").exists()
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
        named = checks[str(name)].damage or checks[str(name)].note
        outcome = after_damage(toys, tmp_path / name.name, expected)
        assert named or outcome == "same", (
            name
        )  # a cut between two lines of the journal is as an earlier kill
        assert checks[str(name)].meaning


def test_verify_says_what_is_whole_what_is_damaged_and_what_that_means(tmp_path, runs, capsys):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    assert tacos_main(["verify", str(tmp_path / "run")]) == 0
    assert "ok  checkpoint.json" in capsys.readouterr().out
    with (tmp_path / "run" / "result.json").open("a") as file:
        file.write(" ")
    assert tacos_main(["verify", str(tmp_path / "run")]) == 1
    said = capsys.readouterr().out
    assert "BAD result.json: it does not end with its checksum" in said
    assert "--resume writes it anew" in said
    assert tacos_main(["verify", str(tmp_path)]) == 2


@pytest.mark.parametrize(
    ("key", "value"),
    [("searches", {}), ("searches", []), ("seconds", "x"), ("weights", {"designed.learner": ["../x", "0"]})],
)
def test_a_checkpoint_with_a_checksum_that_fits_and_strange_content_is_refused(
    toys, tmp_path, runs, key, value
):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    path = tmp_path / "run" / "checkpoint.json"
    path.write_bytes(json_with_checksum({**checked_json(path.read_bytes()), key: value}))
    with pytest.raises(UserError, match="the file is damaged"):
        run(recipe(), toys, tmp_path / "run", resume=True)


def test_a_named_pipe_in_place_of_a_file_does_not_hang(toys, tmp_path, runs):
    shutil.copytree(runs[0] / "whole", tmp_path / "run")
    (tmp_path / "run" / "checkpoint.json").unlink()
    os.mkfifo(tmp_path / "run" / "checkpoint.json")
    with pytest.raises(UserError, match="it is a named pipe"):
        run(recipe(), toys, tmp_path / "run", resume=True)


def test_lines_are_chained_so_that_none_can_go_missing(tmp_path):
    with Results.create(tmp_path, {"name": "x"}) as results:
        for number in range(3):
            results.append_line("lines.jsonl", {"n": number})
        first, _, third = (tmp_path / "lines.jsonl").read_bytes().splitlines(keepends=True)
        (tmp_path / "lines.jsonl").write_bytes(first + third)
        with pytest.raises(UserError, match="the checksum of line 2 does not fit"):
            results.read_lines("lines.jsonl")
