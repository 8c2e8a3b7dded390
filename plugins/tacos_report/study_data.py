"""Reads a results folder into plain values; what is optional may be missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tacos_framework import UserError, read_yaml
from tacos_framework.files import read_bytes
from tacos_framework.store import DESIGNED, read_result, read_run_lines
from tacos_report.analysis import Analysis, RankedPart, read_analysis
from tacos_report.plain_values import finite, mapping, numbers, text, texts
from tacos_report.plain_values import rows as plain_rows
from tacos_report.quantities import unit_of


@dataclass(frozen=True)
class CameraResult:
    """A camera with what it reached on the test scenes.

    ``spread`` holds standard errors over test episodes, for scores and for ``fitness``, and ``episodes``
    the numbers of each test episode, in the same order for every camera; ``scores``,
    ``terms`` and ``fitness`` are empty or None where the test has not run. ``scenarios`` has scores and
    fitness of each scenario by itself, where there is more than one.
    """

    name: str
    title: str
    camera: Mapping[str, Any]
    derived: Mapping[str, float]
    scores: Mapping[str, float] = field(default_factory=dict)
    terms: Mapping[str, float] = field(default_factory=dict)
    spread: Mapping[str, float] = field(default_factory=dict)
    episodes: tuple[Mapping[str, float], ...] = ()
    fitness: float | None = None
    evaluations: int | None = None
    free: tuple[str, ...] = ()
    samples: tuple[Path, ...] = ()
    scenarios: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def pitch_deg(self) -> float:
        """Mounting pitch, positive up; level where the camera has none [deg]."""
        pitch = self.camera.get("pitch_deg", 0.0)
        return float(pitch) if isinstance(pitch, int | float) else 0.0

    @property
    def baseline_m(self) -> float | None:
        """Distance between the two cameras of a stereo rig, else None [m]."""
        baseline = self.camera.get("baseline_m")
        return float(baseline) if isinstance(baseline, int | float) else None


@dataclass(frozen=True)
class Tried:
    """A candidate of the search; ``failed`` says why it has no fitness."""

    generation: int
    camera: Mapping[str, Any]
    derived: Mapping[str, float]
    fitness: float | None
    failed: str | None = None
    scores: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Generation:
    """One round of the search; ``frames`` counts the images rendered in it."""

    number: int
    frames: int
    tried: tuple[Tried, ...]


@dataclass(frozen=True)
class StudyData:
    """All the report needs. ``result`` is ``result.json`` as it stands, for what is shown as it is."""

    result: Mapping[str, Any]
    cameras: tuple[CameraResult, ...]
    generations: tuple[Generation, ...]
    recipe: str = ""
    log: str = ""
    scene_map: Path | None = None
    eye_height_m: float = 1.6
    notes: tuple[str, ...] = ()
    analysis: Analysis = field(default_factory=Analysis)
    asks_for_test: bool = True
    f_number: float | None = None

    @property
    def designed(self) -> CameraResult | None:
        """The winner of the search; None where no candidate succeeded."""
        return next((camera for camera in self.cameras if camera.name == DESIGNED), None)

    def shows_design(self, camera: Mapping[str, Any]) -> bool:
        return self.designed is not None and dict(camera) == dict(self.designed.camera)

    def has_parts_of_design(self, part: RankedPart) -> bool:
        """True if a row of the ranking has the designed camera's parts, whatever its optics."""
        if self.designed is None or self.analysis.degenerate:
            return False
        parts = parts_of(self.designed.camera)
        return parts_of(part.camera) == parts if parts else part.part == self.designed.name

    @property
    def others(self) -> tuple[CameraResult, ...]:
        return tuple(camera for camera in self.cameras if camera.name != DESIGNED)

    @property
    def ground(self) -> str:
        """Ground that the carrier of the cameras moves on."""
        return "ground" if self.carrier == "car" else "floor"

    @property
    def carrier(self) -> str:
        """Carrier of the cameras, as the scene names it: ``person``, ``car``, ...; else empty."""
        return text(self.result.get("carrier"))

    @property
    def score_meanings(self) -> Mapping[str, str]:
        return {name: text(said) for name, said in mapping(self.result.get("score_meanings")).items()}

    def title_of(self, name: str) -> str:
        without_results = {each.against: each.title for each in self.analysis.comparisons if each.title}
        titles = {**without_results, **{camera.name: camera.title for camera in self.cameras}}
        return titles.get(name, name.replace("_", " "))

    @property
    def tested(self) -> bool:
        return self.designed is not None and self.designed.fitness is not None

    @property
    def tried(self) -> tuple[Tried, ...]:
        return tuple(candidate for generation in self.generations for candidate in generation.tried)

    @property
    def scored(self) -> tuple[Tried, ...]:
        return tuple(candidate for candidate in self.tried if candidate.fitness is not None)

    @property
    def best_fitness(self) -> float | None:
        return finite(mapping(self.result.get("best")).get("fitness"))

    @property
    def units(self) -> Mapping[str, str]:
        space = {row["name"]: row.get("unit") or unit_of(row["name"]) for row in self.design_space}
        return {**space, **mapping(self.result.get("derived_units"))}

    @property
    def design_space(self) -> list[dict[str, Any]]:
        return [dict(row) for row in plain_rows(self.result.get("design_space")) if "name" in row]


def parts_of(camera: Mapping[str, Any]) -> dict[str, str]:
    """The names of the parts in a camera, by variable.

    >>> parts_of({"sensor": {"name": "IMX219"}, "pitch_deg": -20.0})
    {'sensor': 'IMX219'}
    """
    return {name: text(value.get("name")) for name, value in camera.items() if isinstance(value, Mapping)}


def read_study(folder: Path) -> StudyData:
    """Read a results folder. Raises UserError where ``result.json`` is missing or is not a JSON object."""
    result = read_result(folder)
    generations = read_generations(folder / "generations.jsonl")
    recipe = _text(folder / "recipe.yaml")
    document = document_of(recipe)
    notes = list(texts(result.get("notes")))
    scene_map = result.get("scene_map")
    return StudyData(
        result=result,
        cameras=tuple(_cameras(folder, result)),
        generations=generations,
        recipe=recipe,
        log=_text(folder / "log.txt"),
        scene_map=_inside(folder, scene_map),
        eye_height_m=_eye_height_m(document),
        notes=tuple(notes),
        analysis=read_analysis(result),
        asks_for_test=not document or document.get("test") is not None,
        f_number=finite(mapping(document.get("scenario")).get("f_number")),
    )


def read_generations(path: Path) -> tuple[Generation, ...]:
    return tuple(map(_generation, read_run_lines(path)))


def _generation(row: Mapping[str, Any]) -> Generation:
    number = int(finite(row.get("generation")) or 0)
    tried = tuple(
        Tried(
            generation=number,
            camera=mapping(candidate.get("camera")),
            derived=numbers(candidate.get("derived")),
            fitness=finite(candidate.get("fitness")),
            failed=candidate.get("failed"),
            scores=numbers(candidate.get("scores")),
        )
        for candidate in plain_rows(row.get("candidates"))
    )
    return Generation(number, int(finite(row.get("frames")) or 0), tried)


def _cameras(folder: Path, result: Mapping[str, Any]) -> list[CameraResult]:
    rows = {name: row for name, row in mapping(result.get("cameras")).items() if isinstance(row, Mapping)}
    best = mapping(result.get("best"))
    if mapping(best.get("camera")) and DESIGNED not in rows:  # stopped before the test
        rows = {DESIGNED: best, **rows}
    names = sorted(rows, key=lambda name: name != DESIGNED)  # the winner first, the rest as they stand
    return [_camera(folder, result, name, rows[name]) for name in names]


def _camera(folder: Path, result: Mapping[str, Any], name: str, row: Mapping[str, Any]) -> CameraResult:
    test = numbers(mapping(result.get("test")).get(name))
    title = "Designed camera" if name == DESIGNED else row.get("title") or name.replace("_", " ")
    samples = texts(mapping(result.get("samples")).get(name))
    return CameraResult(
        name=name,
        title=str(title),
        camera=mapping(row.get("camera")),
        derived=numbers(row.get("derived")),
        scores={score: value for score, value in test.items() if score != "fitness"},
        terms=numbers(row.get("terms")) if test else {},
        scenarios={name: numbers(scores) for name, scores in mapping(row.get("scenarios")).items()},
        spread=numbers(row.get("spread")),
        episodes=tuple(numbers(episode) for episode in plain_rows(row.get("episodes"))),
        fitness=test.get("fitness"),
        evaluations=row.get("evaluations"),
        free=texts(row.get("free")),
        samples=tuple(path for sample in samples if (path := _inside(folder, sample))),
    )


def _inside(folder: Path, name: Any) -> Path | None:
    """The file of that name, if it exists and lies in the folder: a result cannot pull in others."""
    if not text(name):
        return None
    try:
        path = (folder / name).resolve()
        return path if path.is_relative_to(folder.resolve()) and path.is_file() else None
    except (OSError, ValueError):  # a name too long, or with a NUL
        return None


def _text(path: Path) -> str:
    return read_bytes(path, "lines_mb").decode("utf-8", "replace") if path.exists() else ""


def document_of(recipe: str) -> Mapping[str, Any]:
    try:
        return mapping(read_yaml(recipe).data)
    except UserError:
        return {}


def _eye_height_m(recipe: Mapping[str, Any]) -> float:
    """Height of the cameras: the middle of the heights of the agent's eye in the recipe, and the mount's.

    The field's default where no node has such a height.
    """
    mount_m = finite(mapping(recipe.get("rig")).get("height_above_eye_m")) or 0.0
    for node in mapping(recipe.get("nodes")).values():
        height = mapping(node).get("camera_height_m")
        ends = height if isinstance(height, list) else [height]
        known = [end for end in map(finite, ends) if end is not None]
        if known:
            return sum(known) / len(known) + mount_m
    return StudyData.eye_height_m + mount_m
