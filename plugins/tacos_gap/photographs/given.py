"""Answers of the photographer on camera, board and pictures, and the import's guesses in their place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tacos_framework import Fault, UserError

POSSIBLE = {
    "pixel_um": (0.1, 1000.0, "um"),
    "focal_length_mm": (0.1, 10_000.0, "mm"),
    "black_level_dn": (0.0, 65_535.0, "DN"),
    "bit_depth": (1, 16, "bits"),
    "square_mm": (0.01, 10_000.0, "mm"),
}
"""Least and largest number of what may be given, with its unit."""

KINDS = ("dark", "flat", "bracket", "edge", "board", "chart", "sequence", "scene")
FILTERS = ("RGGB", "BGGR", "GRBG", "GBRG")


@dataclass(frozen=True)
class Given:
    """Answers of the photographer on camera and board; None leaves it to the files.

    Raises UserError when a number cannot be that of a camera or of a board; all of them together.
    """

    pixel_um: float | None = None
    """As in ``captures.yaml``, like the four below."""
    focal_length_mm: float | None = None
    black_level_dn: float | None = None
    bit_depth: int | None = None
    cfa: str | None = None
    inner_corners: tuple[int, int] | None = None  # of the board, along its rows and columns
    square_mm: float | None = None
    kinds: Mapping[str, str] = field(default_factory=dict)  # by the name of a picture
    exposures_ms: Mapping[str, float] = field(default_factory=dict)  # by the name of a picture

    def __post_init__(self) -> None:
        faults = [
            Fault(f"--{name.replace('_', '-')}", f"is {value:g}", f"{least:g} to {most:g} {unit}".rstrip())
            for name, (least, most, unit) in POSSIBLE.items()
            if (value := getattr(self, name)) is not None and not least <= value <= most
        ]
        if faults:
            raise UserError(faults)


@dataclass(frozen=True)
class Guess:
    """Assumption of the import that no file states."""

    text: str  # what is taken, why, and what else it may be
    key: str = ""  # the field of `Given` that settles it; empty where a file has to
    assumed: str = ""
    pictures: tuple[str, ...] = ()  # the names of the pictures that a kind or a time is guessed of


def asked(
    guesses: Sequence[Guess], given: Given, ask: Callable[[str], str], tell: Callable[[str], None]
) -> Given:
    """Given values, with the answers of the photographer; an empty answer leaves a guess.

    `ask`: gives the answer to a question; `EOFError` ends the questions.
    """
    for guess in guesses:
        if not guess.key:
            continue
        tell(guess.text)
        while True:
            try:
                answer = ask(f"  {guess.key} [{guess.assumed or 'unknown'}]: ").strip()
            except EOFError:
                return given
            if not answer:
                break
            try:
                given = _with_answer(given, guess, answer)
                break
            except UserError as error:
                tell(f"  {error.faults[0].what}; expected: {error.faults[0].expected}")
    return given


def _with_answer(given: Given, guess: Guess, answer: str) -> Given:
    if guess.key == "kinds":
        return replace(given, kinds={**given.kinds, **dict.fromkeys(guess.pictures, _one_of(KINDS, answer))})
    if guess.key == "exposures_ms":
        times = dict.fromkeys(guess.pictures, _number(answer))
        return replace(given, exposures_ms={**given.exposures_ms, **times})
    value: object
    if guess.key == "inner_corners":
        value = corners_of(answer)
    elif guess.key == "cfa":
        value = _one_of(FILTERS, answer.upper())
    else:
        value = _number(answer)
    changed: dict[str, Any] = {guess.key: value}
    return replace(given, **changed)


def corners_of(text: str, where: str = "--board") -> tuple[int, int]:
    """The two numbers of ``9x6``. Raises UserError when it is no board."""
    first, _, second = text.lower().partition("x")
    if not (first.isdecimal() and second.isdecimal() and min(int(first), int(second)) >= 3):
        expected = "9x6: inner corners along rows and columns, 3 at least"
        raise UserError(Fault(where, f"{text!r} is no board", expected))
    return int(first), int(second)


def _one_of(choices: Sequence[str], answer: str) -> str:
    if answer not in choices:
        raise UserError(Fault("answer", f"{answer!r} is none of them", ", ".join(choices)))
    return answer


def _number(answer: str) -> float:
    try:
        number = float(answer)
    except ValueError:
        number = -1.0
    if not 0 <= number < 1e9:
        raise UserError(Fault("answer", f"{answer!r} is no such number", "a number such as 12.5"))
    return number
