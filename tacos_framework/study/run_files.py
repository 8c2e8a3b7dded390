"""Types of what the files of a study hold: a checksum that fits is no proof that a study wrote them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tacos_framework.errors import UserError
from tacos_framework.results.reading import damage

Scores = dict[str, float]
WeightsFile = tuple[Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]+$")], str]
"""Name of a file under ``weights/``, without its ending, and its checksum."""


class _Kept(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class KeptEvaluation(_Kept):
    """An `Evaluation` without states and error."""

    values: dict[str, Any]
    derived: Scores
    scores: Scores
    fitness: float | None
    terms: Scores
    failed: str | None
    episodes: list[Scores]
    images: int
    seconds: Scores
    cached: bool
    scenario_episodes: dict[str, list[Scores]]
    scenarios: dict[str, Scores]
    broken: Scores
    episode_numbers: list[int]


class JournalLine(_Kept):
    """One evaluation since the last checkpoint."""

    job: str
    seconds: float
    evaluation: KeptEvaluation
    weights: dict[str, WeightsFile]


class GenerationLine(_Kept):
    """One generation of the design, or of what is searched for a product."""

    product: str | None = None
    generation: int
    seconds: float
    frames: int
    candidates: list[dict[str, Any]]
    best: dict[str, Any] | None


class KeptStats(_Kept):
    """What is remembered of a candidate."""

    values: dict[str, Any]
    fitness_sum: float
    times: int


class KeptEnd(_Kept):
    """A search as it was before the most promising candidates were scored once more."""

    best: KeptEvaluation | None
    evaluations: int
    images: int


class KeptFailures(_Kept):
    """How many candidates failed alike, one after the other."""

    count: int
    component: str
    kind: str


class KeptSearch(_Kept):
    """A search."""

    generation: int
    n_observed: int
    evaluations: int
    images: int
    stopped: str | None
    partly_scored: bool
    broken_in_a_row: int
    failed_alike: int
    common_failure: str | None
    last_failure: str | None
    finalists_rescored: bool
    trained_best: int
    finalists: list[KeptEvaluation]
    best: KeptEvaluation | None
    searched: KeptEnd | None
    failing: KeptFailures
    candidate_stats: dict[str, KeptStats]
    cache: dict[str, KeptEvaluation]
    optimizer: dict[str, Any] | None


class LinesEnd(_Kept):
    """How far a file of lines went."""

    lines: int = Field(ge=0)
    checksum: str


class KeptCheckpoint(_Kept):
    """``checkpoint.json``."""

    format: int
    budget: float | None
    searches: dict[str, KeptSearch]
    seconds: float
    seconds_by_node: Scores
    weights: dict[str, WeightsFile]
    test: dict[str, KeptEvaluation]
    lines: dict[str, LinesEnd]
    samples: dict[str, str]


Type = TypeVar("Type", bound=BaseModel)


def check_type(path: Path, kind: type[Type], values: Iterable[Mapping[str, Any]]) -> None:
    """Check what a file of a run holds.

    Raises
    ------
    UserError
        With the first thing in it that is of another type.
    """
    if what := mistyped(kind, values):
        raise UserError(damage(path, what))


def mistyped(kind: type[Type], values: Iterable[Mapping[str, Any]]) -> str | None:
    """The first thing in what a file of a run holds that is of another type; None where there is none."""
    for number, value in enumerate(values, 1):
        try:
            kind.model_validate(value)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            return f"entry {number}, {'.'.join(map(str, first['loc']))}: {first['msg']}"
    return None
