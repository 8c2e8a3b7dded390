"""Folders that cannot be written, that vanish, that are in use: said in a sentence, and nothing is lost."""

from __future__ import annotations

import errno
import json
import multiprocessing
import os
import resource
import shutil
import signal
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

from tacos_framework.cli.exits import exit_status
from tacos_framework.errors import Fault, UserError
from tacos_framework.plugins import Plugins
from tacos_framework.store import Results

RECIPE = {"tacos": 1, "name": "x"}


def _run_with_little_room(out: Path, largest_file_bytes: int, ended) -> None:
    """A child that may write files of a certain size only, as on a disk that fills up."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file_bytes, largest_file_bytes))
    ended.put(exit_status(lambda: bool(run(toy_recipe(**LEARNER), plugins, out))))


@pytest.mark.parametrize("largest_file_bytes", [40_000, 60_000, 120_000])
def test_a_disk_that_fills_up_ends_the_run_in_a_sentence_and_loses_nothing(
    toys, tmp_path, capfd, largest_file_bytes
):
    out = tmp_path / "out"
    spawn = multiprocessing.get_context("spawn")
    ended = spawn.SimpleQueue()
    child = spawn.Process(target=_run_with_little_room, args=(out, largest_file_bytes, ended))
    child.start()
    child.join()
    assert child.exitcode == 0
    assert ended.get() == 2
    said = capfd.readouterr().err
    assert "the results cannot be written: " in said
    assert "go on with --resume" in said
    assert "Traceback" not in said
    assert not list(out.glob("*.partial"))
    resumed = run(toy_recipe(**LEARNER), toys, out, resume=True)
    assert comparable(resumed) == comparable(run(toy_recipe(**LEARNER), toys, tmp_path / "whole"))


class Meanwhile:
    """Does something when a generation ends."""

    def __init__(self, act) -> None:
        self.act = act

    def phase(self, title, candidates):
        pass

    def evaluated(self, evaluation):
        pass

    def best(self, best):
        self.act()


def test_a_folder_removed_during_the_run_ends_it_in_a_sentence(toys, tmp_path):
    out = tmp_path / "out"
    with pytest.raises(UserError, match="the results folder was removed meanwhile"):
        run(toy_recipe(), toys, out, progress=Meanwhile(lambda: shutil.rmtree(out)))
    assert not out.exists()


def test_a_second_run_into_the_same_folder_is_refused_and_the_first_goes_on(toys, tmp_path):
    out, refused = tmp_path / "out", []

    def run_too() -> None:
        for resume in (False, True):
            with pytest.raises(UserError) as caught:
                run(toy_recipe(), toys, out, resume=resume)
            refused.append(caught.value.faults[0].what)

    result = run(toy_recipe(), toys, out, progress=Meanwhile(run_too))
    assert set(refused) == {"another run is writing into this folder"}
    assert comparable(result) == comparable(run(toy_recipe(), toys, tmp_path / "alone"))


def test_the_folder_is_free_again_when_a_run_has_ended_in_whatever_way(toys, tmp_path):
    recipe = toy_recipe(nodes={"width": {"crash_above_deg": 10}}, study={"on_error": "stop"})
    with pytest.raises(ZeroDivisionError):
        run(recipe, toys, tmp_path)
    with pytest.raises(ZeroDivisionError):
        run(recipe, toys, tmp_path, resume=True)


@pytest.mark.parametrize("folder", ["/proc/tacos", "/dev/null/out"])
def test_places_where_no_folder_can_be_are_refused_before_any_work(folder):
    with pytest.raises(UserError, match="the results cannot be written") as caught:
        Results.create(Path(folder), RECIPE)
    assert "Name another folder with --out." in str(caught.value)


def test_a_folder_that_has_become_read_only_is_refused_on_resume(toys, tmp_path, monkeypatch):
    run(toy_recipe(), toys, tmp_path)

    opened = Path.open

    def read_only(path: Path, mode: str = "r", *options: object, **more: object) -> object:
        if mode[0] != "r":
            raise PermissionError(13, "Permission denied")
        return opened(path, mode, *options, **more)

    monkeypatch.setattr(Path, "open", read_only)  # a superuser may write anywhere
    with pytest.raises(UserError, match="the results cannot be written: Permission denied"):
        run(toy_recipe(), toys, tmp_path, resume=True)


def test_what_a_run_left_that_died_before_it_began_does_not_stand_in_the_way(tmp_path):
    for begin in (Results.create, lambda *a: Results.resume(*a)[0]):
        folder = tmp_path / begin.__name__
        folder.mkdir()
        (folder / "recipe.yaml.partial").write_text("tac")
        with begin(folder, RECIPE):
            assert (folder / "recipe.yaml").exists()


def test_a_database_of_somebody_else_is_left_alone(tmp_path):
    with closing(sqlite3.connect(tmp_path / "run.sqlite")) as connection, connection:
        connection.execute("CREATE TABLE runs (name TEXT)")
    before = (tmp_path / "run.sqlite").read_bytes()
    with pytest.raises(UserError, match="not empty"):
        Results.create(tmp_path, RECIPE)
    with pytest.raises(UserError, match="no run to resume"):
        Results.resume(tmp_path, RECIPE)
    assert (tmp_path / "run.sqlite").read_bytes() == before


@pytest.mark.parametrize("page", [b"", b"SQLite format 3\0" + bytes(4080)])
def test_a_database_that_was_never_finished_does_not_stand_in_the_way(tmp_path, page):
    (tmp_path / "run.sqlite").write_bytes(page)
    with Results.create(tmp_path, RECIPE) as results:
        assert results.read_lines("lines.jsonl") == []


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("recipe.yaml", "- a list"),
        ("recipe.yaml", "{"),
        ("run.sqlite", ""),
        ("run.sqlite", "[]"),
        ("run.sqlite", "SQLite format 3\0\udcff"),
    ],
)
def test_files_that_are_damaged_are_refused_in_a_sentence(tmp_path, name, content):
    Results.create(tmp_path, RECIPE).close()
    (tmp_path / name).write_bytes(content.encode("utf-8", "surrogateescape"))
    with pytest.raises(UserError) as caught:
        Results.resume(tmp_path, RECIPE)
    (fault,) = caught.value.faults
    assert isinstance(fault, Fault)
    assert fault.where in (str(tmp_path / name), str(tmp_path))


def test_a_database_of_another_version_is_refused_and_says_so(tmp_path):
    Results.create(tmp_path, RECIPE).close()
    with closing(sqlite3.connect(tmp_path / "run.sqlite")) as connection:
        connection.execute("PRAGMA user_version = 4")
    with pytest.raises(UserError, match="it is of another version of tacos-framework: format 4"):
        Results.resume(tmp_path, RECIPE)


def test_a_folder_of_a_version_without_a_database_is_refused_and_says_so(tmp_path):
    (tmp_path / "recipe.yaml").write_text("tacos: 1\nname: x\n")
    (tmp_path / "checkpoint.json").write_text('{"format": 4, "searches": []}')
    with pytest.raises(UserError, match=r"another version of tacos-framework: it has a checkpoint\.json"):
        Results.resume(tmp_path, RECIPE)


def test_a_last_line_cut_short_is_mended(tmp_path):
    with Results.create(tmp_path, RECIPE) as results:
        results.append_line("lines.jsonl", {"n": 1})
    with (tmp_path / "lines.jsonl").open("a") as file:
        file.write('{"n": 2')
    with Results.resume(tmp_path, RECIPE)[0] as results:
        results.append_line("lines.jsonl", {"n": 3})
        assert results.read_lines("lines.jsonl") == [{"n": 1}, {"n": 3}]
        assert json.dumps(results.read_lines("none.jsonl")) == "[]"
    assert (tmp_path / "lines.jsonl").read_text() == '{"n": 1}\n{"n": 3}\n'


def test_a_folder_that_could_not_be_begun_is_let_go_of(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr("tacos_framework.store.folder.replace_file", full_disk)
        with pytest.raises(UserError, match="cannot be written"):
            Results.create(tmp_path, RECIPE)
    Results.create(tmp_path, RECIPE).close()  # there is room again


def full_disk(path, data):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_an_entry_that_would_take_the_memory_is_refused(tmp_path, monkeypatch):
    with Results.create(tmp_path, RECIPE) as results:
        results.append_line("lines.jsonl", {"n": "long" * 30_000})
    monkeypatch.setenv("TACOS_LIMITS", "lines_mb=0.1")
    with pytest.raises(UserError, match="too big"):
        Results.resume(tmp_path, RECIPE)
