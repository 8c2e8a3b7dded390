"""What a diagnosis says while it runs."""

from __future__ import annotations

import threading

from tacos_framework.simulation import Evaluation
from tacos_gap.answer.diagnosis import CLOSED_FORMS
from tacos_gap.procedures.progress import Telling, done_after


class Heard:
    def __init__(self) -> None:
        self.notes: list[str] = []
        self.twice = threading.Event()

    def phase(self, title: str, candidates: int | None) -> None: ...

    def evaluated(self, evaluation: Evaluation) -> None: ...

    def best(self, best: Evaluation | None) -> None: ...

    def step(self, note: str = "") -> None:
        self.notes.append(note)
        if len(self.notes) > 1:
            self.twice.set()


def test_a_stage_is_said_with_what_is_left_by_what_it_took() -> None:
    heard, now = Heard(), iter([0.0, 0.0, 0.0, 60.0, 60.0, 300.0, 300.0])
    tell = Telling(heard, clock=lambda: next(now))
    tell("measuring the captures")
    tell("trying effects")
    tell("vignetting")
    assert "left" not in heard.notes[0]
    assert heard.notes[1].startswith("trying effects (")
    assert "about 9 min left" in heard.notes[1]
    assert "about 8 min left" in heard.notes[2]


def test_a_long_stage_is_not_silent() -> None:
    heard = Heard()
    with Telling(heard, every_s=0.01) as tell:
        tell("trying effects")
        assert heard.twice.wait(10)
    said = len(heard.notes)
    assert heard.notes[-1].startswith("still trying effects")
    assert len(heard.notes) == said, "silent once it is over"


def test_what_is_gone_never_falls() -> None:
    share = 0.0
    for text in (
        CLOSED_FORMS,
        "measuring the captures",
        "trying effects",
        "a",
        "a + b",
        "a + b + c",
        "comparing with rivals",
        "closure of the gap",
    ):
        later = done_after(share, text)
        assert share <= later < 1
        assert later == 0 or text not in (CLOSED_FORMS, "measuring the captures")
        share = later
