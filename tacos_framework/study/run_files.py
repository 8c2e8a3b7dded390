"""Types of what the database of a study holds: a digest that fits is no proof that a study wrote it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from tacos_framework.errors import UserError
from tacos_framework.store.database import damage

Scores = dict[str, float]
WeightsFile = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]+$")]
"""Name of a file under ``weights/``, without its ending."""


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


class KeptJob(_Kept):
    """One evaluation since the last checkpoint."""

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
    """Record of a candidate."""

    values: dict[str, Any]
    fitness_sum: float
    times: int


class KeptEnd(_Kept):
    """A search as it was before the most promising candidates were scored once more."""

    best: KeptEvaluation | None
    evaluations: int
    images: int


class KeptFailures(_Kept):
    """Number of candidates that failed alike, one after the other."""

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


class KeptCheckpoint(_Kept):
    """Progress of a study."""

    budget: float | None
    searches: dict[str, KeptSearch]
    seconds: float
    seconds_by_node: Scores
    weights: dict[str, WeightsFile]
    test: dict[str, KeptEvaluation]
    lines: dict[str, Annotated[int, Field(ge=0)]]


Type = TypeVar("Type", bound=BaseModel)


def checked_type(kind: type[Type], path: Path, what: str, value: Any) -> Type:
    """A value from the database of a run, checked to be of a type.

    Raises `UserError` with the first thing in it that is of another type.
    """
    try:
        return kind.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise UserError(damage(path, f"{what}, {where}: {first['msg']}")) from error
