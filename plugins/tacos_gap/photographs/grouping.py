"""Photographs gathered into captures: repeated frames, and brackets of one view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from tacos_gap.photographs.picture import Picture
from tacos_gap.photographs.shown import repeated, same_framing, same_shading

FEWEST_TIMES = 2
"""Exposure times that make a bracket."""

_LESS_SHARP = 0.85
"""Share of the sharpness of another picture below which frames are not its repeats (see `repeated`)."""


@dataclass(frozen=True, eq=False)
class Stack:
    """Pictures of one thing under one setting."""

    kind: str  # of the capture they become
    pictures: list[Picture] = field(default_factory=list)
    group: str | None = None  # name of the bracket they are of

    @property
    def first(self) -> Picture:
        return self.pictures[0]


def stacks_of(pictures: Sequence[Picture]) -> list[Stack]:
    """Captures that pictures make.

    Pictures are one capture if they show the same at the same settings; walls, with the same shading. Of
    views that differ by their exposure time alone a bracket is made; a wall's stays a wall as well at the
    time that fills half of the scale, since brackets say nothing of shading.
    """
    stacks: list[Stack] = []
    for picture in pictures:
        kind = picture.shown.kind
        home = (
            next((stack for stack in stacks if _belongs(stack, picture)), None) if kind != "board" else None
        )
        if home is None:
            stacks.append(Stack(kind, [picture]))
        else:
            home.pictures.append(picture)
    return _with_brackets(stacks)


def sharpest_of_views(stacks: Sequence[Stack]) -> dict[Stack, Stack]:
    """For each scene that others show sharper at the same settings, that which shows it sharpest.

    So does a series of focus steps, or a hand that shook in some of its pictures.
    """
    scenes = [stack for stack in stacks if stack.kind == "scene"]
    found = {}
    for stack in scenes:
        of_view = [each for each in scenes if _shows_the_same(each.first, stack.first)]
        sharpest = max(of_view, key=lambda each: each.first.shown.sharpness)
        if stack.first.shown.sharpness < _LESS_SHARP * sharpest.first.shown.sharpness:
            found[stack] = sharpest
    return found


def _shows_the_same(a: Picture, b: Picture) -> bool:
    return _settings(a) == _settings(b) and same_framing(a.shown, b.shown)


def _belongs(stack: Stack, picture: Picture) -> bool:
    return (
        stack.kind == picture.shown.kind
        and _settings(stack.first) == _settings(picture)
        and repeated(stack.first.shown, picture.shown)
    )


def _settings(picture: Picture) -> tuple[object, ...]:
    facts = picture.facts
    return facts.exposure_ms, facts.iso, facts.gain_db, facts.f_number, facts.orientation, picture.size_px


def _with_brackets(stacks: Sequence[Stack]) -> list[Stack]:
    series: list[list[Stack]] = []
    for stack in stacks:
        if stack.kind in ("dark", "board") or stack.first.facts.exposure_ms is None:
            continue
        home = next((members for members in series if _continues(members, stack)), None)
        if home is None:
            series.append([stack])
        else:
            home.append(stack)
    series = [members for members in series if _times(members) >= FEWEST_TIMES]
    taken = {id(stack) for members in series for stack in members}
    found = [stack for stack in stacks if id(stack) not in taken]
    for number, members in enumerate(series, 1):
        if all(stack.kind == "flat" for stack in members):
            found.append(min(members, key=lambda stack: abs(stack.first.shown.level - 0.5)))
        found += [replace(stack, kind="bracket", group=f"view_{number}") for stack in members]
    return found


def _continues(members: Sequence[Stack], stack: Stack) -> bool:
    times = {member.first.facts.exposure_ms for member in members}
    return stack.first.facts.exposure_ms not in times and _one_view(members[-1], stack)


def _one_view(first: Stack, second: Stack) -> bool:
    a, b = first.first, second.first
    if _settings(a)[1:] != _settings(b)[1:]:
        return False
    if first.kind == second.kind == "flat":
        return _brighter_with_time(a, b) and same_shading(a.shown, b.shown, through_a_curve=True)
    return "flat" not in (first.kind, second.kind) and same_framing(a.shown, b.shown)


def _brighter_with_time(a: Picture, b: Picture) -> bool:
    """True if two walls are as bright as their times, so that the lamp was left alone; curves bend ratios."""
    short, long = sorted((a, b), key=lambda picture: picture.facts.exposure_ms or 0.0)
    return long.shown.level > 1.02 * short.shown.level


def _times(members: Sequence[Stack]) -> int:
    return len({stack.first.facts.exposure_ms for stack in members})
