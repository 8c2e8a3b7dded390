"""Faults on the terminal."""

from __future__ import annotations

from tacos_framework.cli.exits import WRONG_INPUT, exit_status
from tacos_framework.errors import Fault, UserError


def test_of_many_faults_of_one_kind_the_first_are_shown_and_all_named(capsys):
    alike = [Fault(f"in/{k}.jpg", f"{k}.jpg is JPEG", "raw frames", "Save raw frames.") for k in range(20)]

    def fail() -> int:
        raise UserError([*alike, Fault("in/t.csv:3", "kind is 'x'", "bright or dark")])

    assert exit_status(fail) == WRONG_INPUT
    told = capsys.readouterr().err
    assert told.startswith("21 faults:\n\nin/0.jpg: 0.jpg is JPEG\n")
    assert told.count("Save raw frames.") == 3
    assert "17 more like it: 3.jpg, 4.jpg" in told
    assert "19.jpg\n\nin/t.csv:3: kind is 'x'" in told


def test_faults_that_differ_in_numbers_are_of_one_kind(capsys):
    def fail() -> int:
        raise UserError(Fault(f"t.csv:{k}", f"names 'img_{k}.png' twice", "each once") for k in range(2, 40))

    assert exit_status(fail) == WRONG_INPUT
    assert capsys.readouterr().err.count("expected: each once") == 3
