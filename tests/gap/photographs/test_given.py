"""Guesses that are asked back in a terminal."""

from __future__ import annotations

import numpy as np

from tacos_framework.cli import tacos_main
from tacos_gap.photographs.given import Given, Guess, asked
from tests.gap.photographs.test_caps_and_walls import SHAPE, save

GUESSES = [
    Guess("It is 3 um.", "pixel_um", "3"),
    Guess("It has 9 x 6.", "inner_corners", "9x6"),
    Guess("a.png is a cap.", "kinds", "dark", ("a.png", "b.png")),
    Guess("Nothing can be asked."),
    Guess("No time.", "exposures_ms", "", ("a.png",)),
]


def test_answers_settle_guesses_and_wrong_ones_are_asked_again():
    answers = iter(["-4", "2.5", "", "wall", "flat", "12.5"])
    said: list[str] = []
    given = asked(GUESSES, Given(cfa="RGGB"), lambda question: next(answers), said.append)
    assert given == Given(
        cfa="RGGB", pixel_um=2.5, kinds={"a.png": "flat", "b.png": "flat"}, exposures_ms={"a.png": 12.5}
    )
    assert "  '-4' is no such number; expected: a number such as 12.5" in said
    assert any("'wall' is none of them" in line for line in said)


def test_the_end_of_the_answers_leaves_the_other_guesses():
    answers = iter(["2.5"])

    def ask(question: str) -> str:
        try:
            return next(answers)
        except StopIteration:
            raise EOFError from None

    assert asked(GUESSES, Given(), ask, lambda line: None) == Given(pixel_um=2.5)


def test_nothing_is_asked_where_nobody_sits_at_a_terminal(tmp_path, capsys, monkeypatch):
    save(tmp_path / "in", "wall_1", np.full(SHAPE, 120.0), 0)
    options = ["captures", "import", str(tmp_path / "in"), "--ask", "--out"]
    assert tacos_main([*options, str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "nothing is asked" in said
    assert "Guessed" in said
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", lambda question: "2.2" if "pixel_um" in question else "")
    assert tacos_main([*options, str(tmp_path / "other")]) == 0
    assert "pixel_um 2.2 (as given)" in capsys.readouterr().out
