"""Entries are made once and never wrong, whoever writes, dies or damages the disk meanwhile."""

from __future__ import annotations

import fcntl
import logging
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tacos_framework.cli import tacos_main
from tacos_plugins.kept_worlds import store as store_module
from tacos_plugins.kept_worlds.store import FOLDER_VARIABLE, WorldStore


@pytest.fixture(autouse=True)
def everything_is_worth_keeping(monkeypatch) -> None:
    monkeypatch.setattr(store_module, "WORTH_KEEPING_S", 0.0)
    monkeypatch.setattr(store_module, "_SPARE_BYTES", 0)


class Maker:
    """Counts how often it is asked."""

    def __init__(self, size: int = 100) -> None:
        self.times, self.size = 0, size

    def __call__(self) -> np.ndarray:
        self.times += 1
        return np.arange(self.size, dtype=np.uint8)


def test_made_once(tmp_path) -> None:
    make = Maker()
    for _ in range(3):
        assert np.array_equal(WorldStore(tmp_path).get("key", make, []), np.arange(100))
    assert make.times == 1
    WorldStore(tmp_path).get("other", make, [])
    assert make.times == 2
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".world", ".world"]


def test_locks_of_processes_that_died_go_and_those_in_use_stay(tmp_path) -> None:
    (tmp_path / "died.lock").touch()
    with (tmp_path / "used.lock").open("wb") as used:
        fcntl.flock(used, fcntl.LOCK_EX)
        WorldStore(tmp_path).get("key", Maker(), [])
        assert {path.name for path in tmp_path.glob("*.lock")} == {"used.lock"}
    WorldStore(tmp_path).clear()
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_entry_is_said_and_made_anew(tmp_path, caplog) -> None:
    make = Maker()
    store = WorldStore(tmp_path)
    store.get("key", make, [])
    (path,) = tmp_path.iterdir()
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with caplog.at_level(logging.WARNING):
        assert np.array_equal(store.get("key", make, []), np.arange(100))
    assert "is damaged and made anew" in caplog.text
    assert make.times == 2
    store.get("key", make, [])
    assert make.times == 2


def test_what_was_used_longest_ago_goes(tmp_path) -> None:
    store = WorldStore(tmp_path)
    for key in "abc":
        store.get(key, Maker(5000), [])
    for age, key in enumerate("bca"):  # b was used longest ago
        os.utime(tmp_path / f"{key}.world", (1000 + age, 1000 + age))
    size = (tmp_path / "a.world").stat().st_size
    store.set_limit(3 * size)
    store.get("d", Maker(5000), [])
    assert {path.stem for path in tmp_path.glob("*.world")} == {"c", "a", "d"}
    store.set_limit(0)
    make = Maker()
    for _ in range(2):
        store.get("e", make, [])
    assert (make.times, store.contents().entries) == (2, 0)


@pytest.mark.parametrize("broken", ["folder is a file", "disk is full"])
def test_without_a_place_to_write_all_goes_on(tmp_path, caplog, monkeypatch, broken: str) -> None:
    folder = tmp_path / "kept"
    if broken == "folder is a file":
        folder.write_text("")
    else:

        def full(path: Path, data: bytes) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(store_module, "write_whole", full)
    store, make = WorldStore(folder), Maker()
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert len(store.get("key", make, [])) == 100
    assert make.times == 3
    assert caplog.text.count("worlds are not kept in") == 1


def test_what_raises_is_not_kept(tmp_path) -> None:
    def fail() -> None:
        raise RuntimeError("no world")

    with pytest.raises(RuntimeError, match="no world"):
        WorldStore(tmp_path).get("key", fail, [])
    assert list(tmp_path.iterdir()) == []


def slow(log: Path) -> np.ndarray:
    with log.open("a") as file:
        file.write("made\n")
    time.sleep(0.3)
    return np.arange(1000)


def ask(folder: Path, log: Path) -> None:
    store_module.WORTH_KEEPING_S = 0.0
    assert WorldStore(folder).get("key", lambda: slow(log), []).sum() == 499500


def test_processes_that_ask_at_the_same_time_make_it_once(tmp_path) -> None:
    log, context = tmp_path / "log", multiprocessing.get_context("spawn")
    processes = [context.Process(target=ask, args=(tmp_path / "kept", log)) for _ in range(3)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0, 0]
    assert log.read_text() == "made\n"


def test_a_maker_that_is_killed_holds_nobody_up(tmp_path) -> None:
    script = (
        "import sys, time; from pathlib import Path; from tacos_plugins.kept_worlds.store import WorldStore\n"
        "def make():\n    print('making', flush=True)\n    time.sleep(60)\n"
        "WorldStore(Path(sys.argv[1])).get('key', make, [])"
    )
    with subprocess.Popen([sys.executable, "-c", script, str(tmp_path)], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"making\n"
        process.send_signal(signal.SIGKILL)
    make = Maker()
    assert len(WorldStore(tmp_path).get("key", make, [])) == 100
    assert make.times == 1


def test_the_command(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "kept"))
    assert tacos_main(["cache", "show"]) == 0
    assert "0 entries, 0.0 MB of 10.0 GB" in capsys.readouterr().out
    WorldStore(tmp_path / "kept").get("key", Maker(200_000), [])
    assert tacos_main(["cache", "limit", "500 MB"]) == 0
    assert "1 entries, 0.2 MB of 500.0 MB" in capsys.readouterr().out
    assert tacos_main(["cache", "clear"]) == 0
    assert "1 entries of 0.2 MB deleted." in capsys.readouterr().out
    assert tacos_main(["cache", "limit", "lots"]) == 2
    assert "'lots' is no size" in capsys.readouterr().err
    monkeypatch.setenv(FOLDER_VARIABLE, "off")
    assert tacos_main(["cache", "show"]) == 0
    assert "No worlds are kept" in capsys.readouterr().out
