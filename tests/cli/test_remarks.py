"""What a checked recipe is told: doubts about parts as a list one can read."""

from __future__ import annotations

import pytest

from tacos_framework.cli import remarks
from tacos_framework.cli.run import main
from tacos_framework.plan.notes import DoubtedParts

LONG = "The data sheet says another thing than the table, " * 4


def test_equal_doubts_are_one_line_and_the_list_is_short(monkeypatch):
    by_doubt = {LONG: tuple("ABCDE"), **{f"Doubt {number}.": ("F",) for number in range(6)}}
    monkeypatch.setattr(remarks, "doubted_parts", lambda plan: [DoubtedParts("mine", 9, by_doubt)])
    monkeypatch.setattr(remarks, "notes_on_search", lambda plan: [])
    monkeypatch.setattr(remarks, "notes_on_catalogs", lambda plan: ["a note"])
    monkeypatch.setattr(remarks, "notes_on_constraints", lambda plan: [])
    monkeypatch.setattr(remarks, "notes_on_assumptions", lambda plan: [])
    monkeypatch.setattr(remarks, "notes_on_middle", lambda plan: [])
    monkeypatch.setattr(remarks, "notes_on_worlds", lambda plan: [])
    monkeypatch.setattr(remarks, "notes_on_shown", lambda plan: [])
    monkeypatch.setattr(remarks, "doubts_of_units", lambda plan: [])
    note, title, first, *others = remarks.remarks(None, verbose=False)
    assert note == "note: a note"
    assert title == "note: Doubts about 6 of 9 parts of mine (--verbose: all, in full):"
    assert first.startswith("  A, B, C and 2 more: The data sheet")
    assert first.endswith("...")
    assert len(first) <= remarks.WIDTH + 2
    assert others == [*(f"  F: Doubt {number}." for number in range(4)), "  and 2 more doubts"]
    _, title, first, *others = remarks.remarks(None, verbose=True)
    assert title == "note: Doubts about 6 of 9 parts of mine:"
    assert first == f"  A, B, C, D, E: {LONG}"
    assert len(others) == 6


@pytest.mark.parametrize(("options", "lines"), [([], 9), (["--verbose"], 24)])
def test_the_shipped_catalog_of_sensors_fits_a_screen(capsys, options, lines):
    assert main(["headset_quick", "--check", *options]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[:1] == ["headset_quick: no faults."]
    assert "sensor.camera assumes figures of 43 of 43 parts of image_sensors" in said[1]
    assert "Doubts about 15 of 43 parts of image_sensors" in said[2]
    assert len(said) == lines


@pytest.mark.parametrize(
    ("settings", "is_short"),
    [
        (["optimizer.evaluations=6"], True),
        (["optimizer.evaluations=9"], False),
        (["optimizer={use: optimizer.genetic, generations: 1}"], True),
        (["optimizer={use: optimizer.genetic, generations: 2}"], False),
        (["optimizer={use: optimizer.cma-es, evaluations: 12}"], True),
        (["optimizer={use: optimizer.cma-es, evaluations: 13}"], False),
        (["optimizer={use: optimizer.optuna, evaluations: 10}"], True),
        (["optimizer={use: optimizer.optuna, evaluations: 11}"], False),
        (["optimizer={use: optimizer.random, evaluations: 4}"], False),
    ],
)
def test_a_search_that_ends_before_it_has_learnt_anything_is_named_one(capsys, settings, is_short):
    options = [word for setting in settings for word in ("--set", setting)]
    assert main(["headset_quick", "--check", *options]) == 0
    assert ("note: Nothing is searched for: the first" in capsys.readouterr().out) is is_short
