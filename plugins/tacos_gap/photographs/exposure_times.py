"""Exposure times of photographs: what cameras, tables and names say, weighed by their brightness."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from tacos_files.exposure_names import possible_time_ms, time_without_unit
from tacos_gap.photographs.facts import OF_NAME
from tacos_gap.photographs.given import Given, Guess
from tacos_gap.photographs.names import settings_in_name
from tacos_gap.photographs.picture import Picture
from tacos_gap.photographs.tables import Row, Table
from tacos_gap.report.words import first_of

_AGREE = 0.1
"""Relative difference of two statements of one time: dials and EXIF round 1/60 s to .0167 or .0156."""

_UNITS_MS = {"seconds": 1e3, "milliseconds": 1.0, "microseconds": 1e-3}

_USUAL_MS = 10.0
"""Exposure time about which those of cameras lie; numbers without a unit count what brings them nearest."""

_CLEAR = 0.5
"""Rank correlation of time and brightness from which on brightness says which way the numbers run."""


def with_times(
    pictures: Sequence[Picture], tables: Sequence[Table], given: Given
) -> tuple[list[Picture], list[str], list[Guess]]:
    """Pictures with the settings that tables and names say beside their own; doubts; guesses.

    What the camera itself wrote comes first, then tables, then names. Answers of the photographer beat all.
    """
    doubts = list(_against_names(pictures))
    guesses: list[Guess] = []
    found = {picture.path.resolve(): picture for picture in pictures}
    for table in tables:
        rows = {path.resolve(): row for path, row in table.rows.items() if path.resolve() in found}
        if not rows:
            continue
        in_ms = _in_ms(table, rows, found, doubts, guesses)
        if in_ms is None:
            continue
        before = dict(found)
        for path, row in rows.items():
            found[path] = _with_row(found[path], row, in_ms, table.path.name)
        if differing := [before[path].name for path in rows if _differ(before[path], rows[path], in_ms)]:
            doubts.append(
                f"{table.path.name} says another exposure time than {first_of(differing)}; the time of the "
                f"camera is taken where it wrote one, else that of the table."
            )
    timed = _with_possible(list(found.values()), guesses)
    return [_with_answers(picture, given) for picture in timed], doubts, guesses


_IN_WORDS = {"exposure_ms": ("exposure time", "ms"), "iso": ("ISO speed", ""), "f_number": ("f-number", "")}


def _against_names(pictures: Sequence[Picture]) -> Iterator[str]:
    """Sentences on settings that the camera wrote and the names of the files contradict."""
    for key, (what, unit) in _IN_WORDS.items():
        differing: dict[str, tuple[float, float]] = {}
        for picture in pictures:
            own, named = getattr(picture.facts, key), settings_in_name(picture.path).get(key)
            if own is not None and named is not None and abs(own - named) > _AGREE * max(own, named):
                differing[picture.name] = (named, own)
        if differing:
            named, own = next(iter(differing.values()))
            yield (
                f"{first_of(list(differing))}: the name says another {what} than the camera wrote ({named:g} "
                f"and {own:g}{' ' + unit if unit else ''}); that of the camera is taken."
            )


def _with_row(picture: Picture, row: Row, in_ms: Callable[[Row], float | None], table: str) -> Picture:
    facts, time_ms = picture.facts, in_ms(row)
    if time_ms is not None and (facts.exposure_ms is None or facts.time_from == OF_NAME):
        facts = replace(facts, exposure_ms=time_ms, time_from=table)
    silent = {
        key: value
        for key in ("iso", "gain_db", "f_number")
        if getattr(facts, key) is None and (value := getattr(row, key)) is not None
    }
    return replace(picture, facts=replace(facts, **silent, kind=row.kind or facts.kind))


def _differ(picture: Picture, row: Row, in_ms: Callable[[Row], float | None]) -> bool:
    own, other = picture.facts.exposure_ms, in_ms(row)
    return own is not None and other is not None and abs(own - other) > _AGREE * max(own, other)


def _in_ms(
    table: Table,
    rows: Mapping[Path, Row],
    pictures: Mapping[Path, Picture],
    doubts: list[str],
    guesses: list[Guess],
) -> Callable[[Row], float | None] | None:
    """Numbers of a table in milliseconds; None where it lists something else."""
    timed = {path: row for path, row in rows.items() if row.time is not None}
    numbers = [float(row.time or 0.0) for row in timed.values()]
    name = table.path.name
    order = _order(numbers, [pictures[path] for path in timed])
    if not table.named and order < _CLEAR:
        doubts.append(
            f"{name} lists as many numbers as there are pictures, and these are not brighter by them: it is "
            f"not taken for their exposure times. Write names beside the numbers."
        )
        return None
    if all(row.ms_per_unit is not None for row in timed.values()):
        if not table.named:
            text = (
                f"{name} is taken for exposure times of the pictures in the order of their names, by which "
            )
            guesses.append(Guess(text + "they get brighter; else write names beside the numbers."))
        return lambda row: None if row.time is None else row.time * (row.ms_per_unit or 1.0)
    if order < -_CLEAR:
        text = (
            f"{name} says no unit: its numbers are taken for parts of a second (1/t), since pictures with "
            f"larger ones are darker; else they are times, and the pictures had other light. Write a heading "
            f"such as exposure_ms."
        )
        guesses.append(Guess(text))
        return lambda row: None if row.time is None else 1e3 / row.time
    unit = _likeliest_unit(numbers)
    guesses.append(
        Guess(
            f"{name} says no unit: its numbers, up to {max(numbers, default=0.0):g}, are taken for {unit}; "
            f"else they are {_other_units(unit)}. Write a heading such as exposure_ms."
        )
    )
    return lambda row: None if row.time is None else row.time * _UNITS_MS[unit]


def _likeliest_unit(numbers: Sequence[float]) -> str:
    """What exposure times without a unit count, by how long cameras expose."""
    middle = float(np.mean(np.log10([number for number in numbers if number > 0] or [1.0])))
    return min(_UNITS_MS, key=lambda unit: abs(middle + np.log10(_UNITS_MS[unit] / _USUAL_MS)))


def _other_units(unit: str) -> str:
    return " or ".join(other for other in _UNITS_MS if other != unit)


def _with_possible(pictures: Sequence[Picture], guesses: list[Guess]) -> list[Picture]:
    """Pictures whose names hold times without a unit (``exposure5000``), or what may be times (``1_250``)."""
    untimed = [picture for picture in pictures if picture.facts.exposure_ms is None]
    numbers = {p: number for p in untimed if (number := time_without_unit(p.path.stem))}
    if numbers and not _count(numbers.values()):
        unit = _likeliest_unit(list(numbers.values()))
        times_ms = {picture: number * _UNITS_MS[unit] for picture, number in numbers.items()}
        why, remedy = "in the unit that cameras likeliest expose for", f"else they count {_other_units(unit)}"
    else:
        times_ms = {p: time_ms for p in untimed if (time_ms := possible_time_ms(p.path.stem))}
        if len(set(times_ms.values())) < 3 or _order(list(times_ms.values()), list(times_ms)) < 0.9:
            return list(pictures)
        why, remedy = "since the pictures get brighter with them", "else they are numbers"
    first = next(iter(times_ms))
    guesses.append(
        Guess(
            f"Names are taken for shutter times ({first.name}: {times_ms[first]:g} ms), {why}; {remedy}. "
            f"Name them as in wall_4ms.png."
        )
    )
    return [
        replace(p, facts=replace(p.facts, exposure_ms=times_ms[p], time_from=OF_NAME)) if p in times_ms else p
        for p in pictures
    ]


def _count(numbers: Iterable[float]) -> bool:
    """True of numbers that only count: ``exp1``, ``exp2``, ``exp3``."""
    distinct = sorted(set(numbers))
    return distinct[0] in (0, 1) and distinct == [distinct[0] + k for k in range(len(distinct))]


def _with_answers(picture: Picture, given: Given) -> Picture:
    if (time_ms := given.exposures_ms.get(picture.name)) is None:
        return picture
    return replace(picture, facts=replace(picture.facts, exposure_ms=time_ms, time_from=""))


def _order(numbers: Sequence[float], pictures: Sequence[Picture]) -> float:
    """Rank correlation between numbers and how bright pictures are; 0 where either is all alike."""
    bright = [float(picture.shown.thumbnail.mean()) for picture in pictures]
    if len(numbers) < 2 or np.ptp(numbers) == 0 or np.ptp(bright) == 0:
        return 0.0
    return float(spearmanr(numbers, bright).statistic)
