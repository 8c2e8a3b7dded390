"""Decision and analysis of a study: keys of ``result.json``, each of them optional."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from tacos_report.plain_values import Interval, finite, interval, mapping, numbers, rows, text, texts

VERDICTS = ("better", "worse", "equivalent", "undecided")
NOT_ADMISSIBLE = "not admissible"


@dataclass(frozen=True)
class Comparison:
    """Designed camera minus a product, in fitness, over paired test scenes; ``why`` where it has no place.

    ``title`` is what people call a product without results, which stands nowhere else.
    """

    against: str
    verdict: str
    difference: float | None = None
    interval: Interval | None = None
    episodes: int = 0
    why: str = ""
    title: str = ""


@dataclass(frozen=True)
class Decision:
    """The comparison with the best product; below ``margin`` [fitness] a difference does not matter."""

    comparison: Comparison
    margin: float
    margins: Mapping[str, float]
    confidence: float


@dataclass(frozen=True)
class RankedPart:
    """A part (or several that go together) at its own best optics; ``ci`` is the 95 % interval of fitness.

    ``p_better`` is the probability that it is better, by product; ``episodes`` counts the scenes it was
    scored on, 0 where the model alone speaks; ``unknown`` names columns that nobody states and that widened
    ``ci``.
    """

    part: str
    camera: Mapping[str, Any]
    fitness: float
    ci: Interval | None
    p_better: Mapping[str, float]
    rescored: bool
    episodes: int
    unknown: tuple[str, ...]


@dataclass(frozen=True)
class Equivalents:
    """Cameras that may be within the margin of the best; ranges are two ends, or the values of a choice.

    ``probability`` is that of a part to lie there.
    """

    margin: float | None
    margins: Mapping[str, float]
    parts: tuple[str, ...]
    probability: Mapping[str, float]
    ranges: Mapping[str, Interval | tuple[str, ...]]
    tolerances: Mapping[str, Interval | tuple[str, ...]]


@dataclass(frozen=True)
class CurvePoint:
    """Fitness at a value of a variable, all else at the best: mean and band."""

    value: float | str
    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Influence:
    """Sobol indices of a variable, by itself and with all it interacts with, and its curve."""

    variable: str
    unit: str
    first_order: float | None
    total: float
    curve: tuple[CurvePoint, ...]


@dataclass(frozen=True)
class Objective:
    """An aim beside the fitness; ``aim`` is max or min."""

    name: str
    unit: str
    aim: str


@dataclass(frozen=True)
class FrontPoint:
    """A camera of the front: none is better in one aim without being worse in another."""

    part: str
    camera: Mapping[str, Any]
    values: Mapping[str, float]
    fitness: float
    ci: Interval | None
    rescored: bool


@dataclass(frozen=True)
class Analysis:
    """All of it; what a result does not have is empty."""

    decision: Decision | None = None
    decision_absent: str = ""
    degenerate: str = ""
    comparisons: tuple[Comparison, ...] = ()
    ranking: tuple[RankedPart, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    equivalents: Equivalents | None = None
    influences: tuple[Influence, ...] = ()
    objectives: tuple[Objective, ...] = ()
    front: tuple[FrontPoint, ...] = ()


def read_analysis(result: Mapping[str, Any]) -> Analysis:
    """The analysis in ``result.json``; rows that lack what they are about are left out."""
    front = mapping(result.get("front"))
    return Analysis(
        decision=_decision(mapping(result.get("decision"))),
        decision_absent=text(result.get("decision_absent")),
        degenerate=text(result.get("degenerate")),
        comparisons=tuple(_comparisons(result.get("comparisons"))),
        ranking=tuple(_ranking(result.get("ranking"))),
        left_out={
            text(row["part"]): text(row.get("why"))
            for row in rows(result.get("ranking_left_out"))
            if text(row.get("part"))
        },
        equivalents=_equivalents(mapping(result.get("equivalent"))),
        influences=tuple(_influences(result.get("importance"))),
        objectives=tuple(
            Objective(text(row["name"]), text(row.get("unit")), text(row.get("aim")) or "max")
            for row in rows(front.get("objectives"))
            if text(row.get("name"))
        ),
        front=tuple(_front(front.get("points"))),
    )


def _comparison(row: Mapping[str, Any]) -> Comparison | None:
    against, verdict = text(row.get("against")), text(row.get("verdict"))
    difference = finite(row.get("difference"))
    if not against or verdict not in (*VERDICTS, NOT_ADMISSIBLE):
        return None
    if verdict in VERDICTS and difference is None:
        return None
    episodes = int(finite(row.get("episodes")) or 0)
    ends, why, title = interval(row.get("interval")), text(row.get("why")), text(row.get("title"))
    return Comparison(against, verdict, difference, ends, episodes, why, title)


def _comparisons(value: Any) -> Iterator[Comparison]:
    return (found for row in rows(value) if (found := _comparison(row)) is not None)


def _decision(row: Mapping[str, Any]) -> Decision | None:
    comparison = _comparison(row)
    if comparison is None or comparison.verdict == NOT_ADMISSIBLE:
        return None
    return Decision(
        comparison,
        margin=finite(row.get("margin")) or 0.0,
        margins=numbers(row.get("margins")),
        confidence=finite(row.get("confidence")) or 0.95,
    )


def _ranking(value: Any) -> Iterator[RankedPart]:
    for row in rows(value):
        part, fitness = text(row.get("part")), finite(row.get("fitness"))
        if part and fitness is not None:
            yield RankedPart(
                part,
                mapping(row.get("camera")),
                fitness,
                interval(row.get("ci")),
                numbers(row.get("p_better")),
                row.get("rescored") is True,
                int(finite(row.get("episodes")) or 0),
                texts(row.get("unknown")),
            )


def _equivalents(row: Mapping[str, Any]) -> Equivalents | None:
    if not row:
        return None
    return Equivalents(
        finite(row.get("margin")),
        numbers(row.get("margins")),
        texts(row.get("parts")),
        {
            name: p
            for name, given in mapping(row.get("probability")).items()
            if (p := finite(given)) is not None
        },
        _ranges(row.get("range")),
        _ranges(row.get("tolerance")),
    )


def _ranges(value: Any) -> dict[str, Interval | tuple[str, ...]]:
    found: dict[str, Interval | tuple[str, ...]] = {}
    for name, given in mapping(value).items():
        if (ends := interval(given)) is not None:
            found[name] = ends
        elif isinstance(given, list) and (choices := tuple(_choice(each) for each in given)):
            found[name] = tuple(filter(None, choices))
    return found


def _choice(value: Any) -> str:
    number = finite(value)
    return text(value) if number is None else f"{number:g}"


def _influences(value: Any) -> Iterator[Influence]:
    for row in rows(value):
        variable, total = text(row.get("variable")), finite(row.get("total"))
        if variable and total is not None:
            curve = tuple(_curve(row.get("curve")))
            yield Influence(variable, text(row.get("unit")), finite(row.get("first_order")), total, curve)


def _curve(value: Any) -> Iterator[CurvePoint]:
    for row in rows(value):
        at: float | str | None = text(row.get("value")) or finite(row.get("value"))
        mean, low, high = (finite(row.get(name)) for name in ("mean", "low", "high"))
        if at is not None and mean is not None:
            yield CurvePoint(at, mean, mean if low is None else low, mean if high is None else high)


def _front(value: Any) -> Iterator[FrontPoint]:
    for row in rows(value):
        fitness = finite(row.get("fitness"))
        if fitness is not None:
            yield FrontPoint(
                text(row.get("part")),
                mapping(row.get("camera")),
                numbers(row.get("values")),
                fitness,
                interval(row.get("ci")),
                row.get("rescored") is True,
            )
