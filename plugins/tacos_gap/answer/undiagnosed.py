"""The answer where no capture of a folder tells anything: nothing is named, and it is said why."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tacos_framework import Fault, UserError
from tacos_gap.captures import CaptureFolder
from tacos_gap.hypotheses.ambiguity import NextCapture

WANTED = NextCapture(
    "flat",
    "two frames of an evenly lit wall, its middle at about half of full scale, show most of what pixels, "
    "readout and lens do",
)
"""What to photograph first: it needs no simulator."""


class NothingMeasured(UserError):
    """A folder was read, and none of its captures can be measured."""

    def __init__(self, fault: Fault, limitations: Sequence[str] = ()):
        super().__init__(fault)
        self.limitations = tuple(limitations)


def nothing_measured(folder: CaptureFolder, limitations: Sequence[str]) -> NothingMeasured:
    fault = Fault(
        str(folder.path),
        "nothing can be measured in any capture",
        "one capture at least that shows something",
        " ".join((*limitations, "Run `tacos captures check` on it.")),
    )
    return NothingMeasured(fault, (*folder.limitations, *limitations))


def undiagnosed_data(limitations: Sequence[str]) -> dict[str, Any]:
    """``diagnosis.json`` with every key of an answer, and nothing that was not measured.

    No gap was measured, so `before` and `after` are 0; what nothing was measured of is not complete.
    """
    return {
        "verdict": "unknown",
        "gap": {
            "before": 0.0,
            "after": 0.0,
            "floor": 1.0,
            "unit": "floor",
            "ci": [0.0, 0.0],
            "closure": {"value": 0.0, "ci": [0.0, 0.0], "held_out": False, "reason": "nothing was measured"},
        },
        "where": [],
        "causes": [],
        "cause_set": [],
        "complete": {"score": 0.0, "by_stage": {}, "by_capture": {}},
        "unknown": {"score": 1.0, "where": None},
        "detectable": {},
        "detectable_in_words": {},
        "closed_forms": [],
        "nuisances": {},
        "next_capture": {"kind": WANTED.kind, "why": WANTED.why},
        "below_floor": [],
        "negative_control": None,
        "task": {},
        "processed": [],
        "limitations": ["Nothing could be measured in any capture.", *limitations],
    }
