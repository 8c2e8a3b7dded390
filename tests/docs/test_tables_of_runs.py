"""Tables for the documentation, from what runs leave."""

from __future__ import annotations

import pytest

from scripts.tables_of_runs import lines_of

RANKS = {
    "name": "r",
    "procedure": "procedure.rank-agreement",
    "study": "small",
    "scenes": 3,
    "tau": {"day": 1.0, "night": None},
    "tau_interval": {"day": [0.8, 1.0], "night": None},
    "table": [
        {"camera": "a", "light": "day", "quick": 1.0, "full": 2.0, "rank_quick": 1.0, "rank_full": 1.0},
        {"camera": "b", "light": "day", "quick": 0.5, "full": 1.5, "rank_quick": 2.0, "rank_full": 2.0},
    ],
}
COMPARED = {
    "name": "c",
    "procedure": "procedure.compare-optimizers",
    "standings": [
        {
            "optimizer": "x",
            "regret": {
                "40": {"low": None, "median": None, "high": None},
                "160": {"low": 0, "median": 0.1, "high": 1},
            },
            "images": {"low": 40.0, "median": 160.0, "high": None},
            "reached": 0.6,
            "ratios": {"ppo": {"value": 33.0, "at_least": True}},
        }
    ],
}


def test_orders_stand_side_by_side():
    lines = list(lines_of(RANKS))
    assert lines[0] == "small, day, 3 scenes: tau 1.00 [0.80, 1.00].\n"
    assert "| b | 2 | 2 | 0.500 | 1.500 |" in lines
    assert "small, night, 3 scenes: no order.\n" in lines


def test_what_was_never_reached_is_said_in_words():
    lines = list(lines_of(COMPARED))
    assert lines[2] == "| x | nothing yet | 0.100 [0.000, 1.000] |"
    assert lines[-1] == "| x | 160 [40, never] | 60% | at least 33.0 |"


def test_other_runs_have_no_tables():
    with pytest.raises(ValueError, match="no tables"):
        list(lines_of({"name": "n", "procedure": "procedure.diagnose"}))
