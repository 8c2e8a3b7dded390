"""What workers log is said by their parent, at its levels and with their names."""

from __future__ import annotations

import io
import logging
import re

import pytest
from rich.console import Console

from tacos_framework.cli import bar
from tacos_plugins.executors.outcomes import JobLost
from tacos_plugins.executors.process import ProcessExecutor
from tests.executors import jobs

LOGGER = "tests.executors.jobs"


def test_lines_of_workers_come_with_their_names_at_the_levels_of_the_parent(caplog, capfd):
    with caplog.at_level(logging.INFO, logger=LOGGER):
        executor = ProcessExecutor(ProcessExecutor.Config(workers=1))
        assert list(executor.map(jobs.say, [5])) == [5]
        executor.close()
    info, error, warned = [record for record in caplog.records if record.name in (LOGGER, "py.warnings")]
    assert (info.levelname, info.getMessage()) == ("INFO", "worker 1: info 5")
    assert (error.levelname, error.processName) == ("ERROR", "tacos-worker-1")
    assert error.getMessage().startswith("worker 1: error 5\nTraceback")
    assert error.getMessage().endswith("ValueError: deep")
    assert re.match(r"worker 1: .*jobs\.py:\d+: RuntimeWarning: warned 5", warned.getMessage())
    assert capfd.readouterr().err == ""


def test_the_last_words_of_a_worker_that_dies_are_heard(caplog):
    executor = ProcessExecutor(ProcessExecutor.Config(workers=1))
    with pytest.raises(JobLost):
        list(executor.map(jobs.say_and_die, [0]))
    executor.close()
    said = [record.getMessage() for record in caplog.records if record.name == LOGGER]
    assert said == ["worker 1: last words", "worker 2: last words"]


@pytest.mark.parametrize(("verbose", "said"), [(False, ["error"]), (True, ["info", "error"])])
def test_lines_of_workers_stand_above_the_bar_and_not_in_it(monkeypatch, caplog, verbose, said):
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=True, width=200)
    monkeypatch.setattr(bar, "Console", lambda **_: console)
    with (
        caplog.at_level(logging.INFO, logger=LOGGER),
        bar.progress_for(quiet=False, verbose=verbose) as progress,
    ):
        progress.phase("Designing", 3)
        executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
        for _ in executor.map(jobs.say, range(3)):
            progress.step()
        executor.close()
    lines = [re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", line) for line in re.split(r"[\r\n]+", screen.getvalue())]
    told = [line for line in lines if "worker" in line and "Warning" not in line]
    assert sorted(re.sub(r"worker \d", "worker N", line).strip() for line in told) == sorted(
        f"{'error: ' if word == 'error' else ''}worker N: {word} {x}" for word in said for x in range(3)
    )
    assert any("Traceback" in line for line in lines) == verbose
