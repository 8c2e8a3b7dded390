"""Pictures without structure: the cap, a wall, or a view in too little light, by all that speaks for either.

Each piece of evidence adds to the logarithm of the odds for the cap. None settles it alone: caps of cameras
with a high pedestal are as bright as dim walls, and files are named by people.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures.targets.wall import shading
from tacos_gap.photographs.given import Given, Guess
from tacos_gap.photographs.picture import Picture
from tacos_gap.photographs.shown import COARSE
from tacos_gap.report.words import first_of

_SURE = 2.5
"""Logarithm of the odds below which a kind is a guess: 12 to 1."""

_LEVELS = ((0.04, 3.0), (0.1, 2.0), (0.15, 0.0), (0.25, -2.0), (np.inf, -6.0))
"""What a level over full scale up to the first number tells of the cap: pedestals lie at 6 %."""

_NAMED, _SHADED, _GROWING = 4.0, 2.5, 2.0

_SAME_VIEW = 0.25
"""Correlation of the finer structure of two pictures from which on they show the same: that of noise alone
scatters by .02 over the 3,072 parts of a thumbnail."""


@dataclass(frozen=True)
class Evidence:
    """Evidence for the cap, or against it. `for_cap`: logarithm of the odds [nat]."""

    for_cap: float
    words: str


def with_kinds_weighed(pictures: Sequence[Picture], given: Given) -> tuple[list[Picture], list[Guess]]:
    """Pictures, those without structure under the kind that most speaks for; and what was guessed of them."""
    pictures = [_as_named(picture) for picture in pictures]
    found = dict(zip(pictures, pictures, strict=True))
    even = [p for p in pictures if p.shown.kind in ("dark", "flat") and p.name not in given.kinds]
    darks = [picture for picture in even if picture.shown.kind == "dark"]
    views = [(p, _fine(p)) for p in pictures if darks and p.shown.kind not in ("dark", "flat")]
    guesses: dict[tuple[str, str], list[str]] = {}
    for picture in even:
        if (view := _view_in_the_dark(picture, views)) is not None:
            found[picture] = _as(picture, view.shown.kind)
            why = f"since they show faintly what {view.name} shows; else of the cap"
            guesses.setdefault((f"pictures of that view, {why}", view.shown.kind), []).append(picture.name)
            continue
        evidence = list(_evidence(picture, even))
        for_cap = sum(each.for_cap for each in evidence)
        kind = "dark" if for_cap > 0 else "flat"
        found[picture] = _as(picture, kind)
        if abs(for_cap) < _SURE:
            bearing = [each for each in evidence if each.for_cap * for_cap > 0]
            taken, other = ("the cap", "a wall") if kind == "dark" else ("a wall", "the cap")
            reasons = " and ".join(each.words for each in bearing) or "nothing speaks for the other"
            guesses.setdefault((f"{taken}, since {reasons}; else {other}", kind), []).append(picture.name)
    for picture in pictures:
        if picture.name in given.kinds:
            found[picture] = _as(picture, given.kinds[picture.name])
    told = [
        Guess(f"{first_of(names)} taken for {what}.", "kinds", kind, tuple(names))
        for (what, kind), names in guesses.items()
    ]
    return list(found.values()), told


def _as_named(picture: Picture) -> Picture:
    """A picture that may be a wall, or a view with little in it, as a wall where its name says that."""
    shown = picture.shown
    if picture.facts.kind != "flat" or shown.kind != "scene" or not shown.doubt:
        return picture
    doubt = "taken for a wall, as its name or a table says; it is more uneven than walls are."
    return replace(picture, shown=replace(shown, kind="flat", doubt=doubt))


def _as(picture: Picture, kind: str) -> Picture:
    return (
        picture if picture.shown.kind == kind else replace(picture, shown=replace(picture.shown, kind=kind))
    )


def _evidence(picture: Picture, even: Sequence[Picture]) -> Iterator[Evidence]:
    shown = picture.shown
    for_cap = next(weight for most, weight in _LEVELS if shown.level < most)
    yield Evidence(for_cap, f"the level is {shown.level:.0%} of full scale")
    if picture.facts.kind is not None:
        yield Evidence(_NAMED if picture.facts.kind == "dark" else -_NAMED, "its name or a table says so")
    yield from _by_shading(picture, even)
    yield from _by_time(picture, even)


def _by_shading(picture: Picture, even: Sequence[Picture]) -> Iterator[Evidence]:
    """The shading of lens and lamp, which brighter walls show and a cap does not."""
    own = _unevenness(picture)
    brighter = [p for p in even if 1.5 * picture.shown.level < p.shown.level < 0.9]
    if not brighter:
        if own < 0.005:
            yield Evidence(_SHADED / 2, "it is even all over")
        elif own > 0.03:
            yield Evidence(-_SHADED / 2, "it is shaded")
        return
    wall = min(brighter, key=lambda p: abs(p.shown.level - 0.5))
    if (of_wall := _unevenness(wall)) < 0.01:
        return
    if own < 0.25 * of_wall:
        yield Evidence(_SHADED, f"it has not the shading of {wall.name}")
    elif own > 0.6 * of_wall and _alike(picture, wall):
        yield Evidence(-_SHADED, f"it is shaded as {wall.name} is")


def _by_time(picture: Picture, even: Sequence[Picture]) -> Iterator[Evidence]:
    """Light grows with the exposure time; the pedestal does not."""
    facts, level = picture.facts, picture.shown.level
    if facts.exposure_ms is None:
        return
    others = [
        p
        for p in even
        if p.facts.exposure_ms is not None
        and (p.facts.iso, p.facts.gain_db) == (facts.iso, facts.gain_db)
        and max(p.facts.exposure_ms, facts.exposure_ms) > 1.8 * min(p.facts.exposure_ms, facts.exposure_ms)
        and level / 4 < p.shown.level < 4 * level
    ]
    if any(abs(p.shown.level - level) < 0.03 * level for p in others):
        yield Evidence(_GROWING, "it is as bright at another exposure time")
    elif any(
        (p.shown.level - level) * ((p.facts.exposure_ms or 0.0) - facts.exposure_ms) > 0 for p in others
    ):
        yield Evidence(-_GROWING, "it gets brighter with the exposure time")


def _view_in_the_dark(
    picture: Picture, views: Sequence[tuple[Picture, NDArray[np.float64]]]
) -> Picture | None:
    """The brighter picture whose view a dark one shows faintly; None where it shows nothing.

    `views`: pictures of views, each with its `_fine` structure.
    """
    if picture.shown.kind != "dark":
        return None
    own = _fine(picture)
    if own.std() == 0:
        return None
    likeness = [(float(np.corrcoef(own, fine)[0, 1]), view) for view, fine in views]
    best = max(likeness, key=lambda each: each[0], default=None)
    return best[1] if best is not None and best[0] > _SAME_VIEW else None


def _fine(picture: Picture) -> NDArray[np.float64]:
    """(P,) what a thumbnail shows beside smooth light."""
    thumbnail = picture.shown.thumbnail
    return (thumbnail - shading(thumbnail, has_defects=False)).ravel().astype(np.float64)


def _parts(picture: Picture) -> NDArray[np.float32]:
    return np.asarray(cv2.resize(picture.shown.thumbnail, COARSE[::-1], interpolation=cv2.INTER_AREA))


def _unevenness(picture: Picture) -> float:
    """Standard deviation over the mean of large parts."""
    parts = _parts(picture)
    return float(parts.std() / max(float(parts.mean()), 1e-6))


def _alike(first: Picture, second: Picture) -> bool:
    return float(np.corrcoef(_parts(first).ravel(), _parts(second).ravel())[0, 1]) > 0.8
