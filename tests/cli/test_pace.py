"""The log says how far a run is, whether anybody watches or not."""

from __future__ import annotations

import logging

import pytest

from tacos_framework.cli.pace import EVERY_S, Logged, Pace
from tacos_framework.simulation import Evaluation
from tacos_framework.study.progress import Silent


class Clock:
    """Time that passes when it is told to [s]."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


class Noting(Silent):
    """Remembers what it is told."""

    def __init__(self) -> None:
        self.told: list[str] = []

    def phase(self, title: str, candidates: int | None) -> None:
        self.told.append(title)

    def step(self, note: str = "") -> None:
        self.told.append(note)


def test_the_rest_takes_as_long_as_what_is_done_did() -> None:
    clock = Clock()
    pace = Pace("Scoring", 10, clock)
    for _ in range(4):
        clock.now_s += 15.0
        pace.done += 1
    assert str(pace) == "Scoring: 4 of 10 done, about 0:01:30 left"
    pace.done = 10
    assert str(pace) == "Scoring: 10 of 10 done"
    pace.done = 11
    assert str(pace) == "Scoring: 11 done"


@pytest.mark.parametrize("first_s", [1.0, 100.0])
def test_what_the_first_has_read_and_lit_is_no_pace(first_s: float) -> None:
    """A world that takes minutes to be lit made the estimate tenfold too high."""
    clock = Clock()
    pace = Pace("Scoring", 100, clock)
    clock.now_s += first_s
    pace.done += 1
    assert str(pace) == "Scoring: 1 of 100 done"
    for done in range(2, 100):
        clock.now_s += 1.0
        pace.done = done
        minutes, seconds = str(pace).split("about ")[1].removesuffix(" left").split(":")[1:]
        assert int(minutes) * 60 + int(seconds) == 100 - done


def test_what_an_earlier_run_has_left_is_no_pace() -> None:
    """24 studies of 160 were read, six took 50 s each: half an hour was said to be left in place of two."""
    clock = Clock()
    pace = Pace("Running studies", 160, clock)
    for done in range(1, 31):
        clock.now_s += 0.05 if done <= 24 else 50.0
        pace.done = done
    assert str(pace) == "Running studies: 30 of 160 done, about 1:48:20 left"


def test_of_an_unknown_whole_only_what_is_done_is_said() -> None:
    pace = Pace("Reading", None)
    pace.done = 3
    assert str(pace) == "Reading: 3 done"


def test_the_log_is_told_now_and_then_and_the_terminal_each_time(caplog: pytest.LogCaptureFixture) -> None:
    clock, shown = Clock(), Noting()
    progress = Logged(shown, clock)
    with caplog.at_level(logging.INFO, "tacos_framework"):
        progress.phase("Diagnosing", 6)
        for case in range(4):
            clock.now_s += 0.6 * EVERY_S
            progress.step(f"case {case}")
        progress.phase("Designing", None)
        clock.now_s += EVERY_S
        progress.evaluated(Evaluation(values={}))
    assert shown.told == ["Diagnosing", "case 0", "case 1", "case 2", "case 3", "Designing"]
    assert caplog.messages == [
        "Diagnosing",
        "Diagnosing: 2 of 6 done, about 0:02:24 left",
        "Diagnosing: 4 of 6 done, about 0:01:12 left",
        "Designing",
        "Designing: 1 done",
    ]
