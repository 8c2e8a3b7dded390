"""What is expected of a setting, in words that need no Python."""

from __future__ import annotations

from typing import Literal

from tacos_framework.settings import Settings, check, setting


class Toy(Settings):
    """Settings that take more than one type."""

    one_or_many: float | tuple[float, ...] = setting(1.0, help="One or many.")
    named: str | float = setting("x", help="A name or a number.")
    pair: tuple[float, float] = setting((1.0, 2.0), help="Two.")
    named_or_pair: Literal["all"] | tuple[float, float] = setting("all", help="All, or two.")
    counts: dict[str, int] = setting({}, help="Counts.")


def faults_of(**given: object) -> list[tuple[str, str]]:
    _, faults, _ = check(Toy, given, lambda path: ".".join(map(str, path)))
    return [(fault.where, fault.expected) for fault in faults]


def test_a_setting_of_several_types_has_one_fault_that_names_them() -> None:
    assert faults_of(one_or_many="x") == [("one_or_many", "a number, or a list, as in [a, b] (One or many)")]
    assert faults_of(named=[]) == [("named", "text, or a number (A name or a number)")]


def test_an_entry_of_a_list_that_might_be_a_number_is_told_by_itself() -> None:
    assert faults_of(one_or_many=[1, "x"]) == [("one_or_many.1", "a number")]


def test_a_list_that_lacks_entries_is_told_once() -> None:
    assert faults_of(pair=[]) == [("pair", "2 entries (Two)")]
    assert faults_of(named_or_pair=[1]) == [("named_or_pair", "'all', or 2 entries (All, or two)")]
    assert faults_of(pair=[1, 2, 3]) == [("pair", "at most 2 entries (Two)")]


def test_numbers_and_switches_have_the_names_people_use() -> None:
    assert faults_of(counts={"a": 1.5}, pair=[1, True]) == [
        ("pair.1", "a number"),
        ("counts.a", "a whole number"),
    ]
