"""A study of toys, for tests of the framework."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.runner import run as run_recipe

LEARNER: Mapping[str, Any] = {
    "nodes": {
        "learner": {"use": "task.toy-learner", "in": {"frames": "frames"}, "train": {"weights": "shared"}}
    },
    "fitness": [{"score": "width.closeness", "weight": 1}, {"score": "learner.knowledge", "weight": 0.01}],
}
"""Sections that add a task that learns."""

FROM_CATALOG: Mapping[str, Any] = {
    "tacos": 1,
    "name": "toy",
    "seed": 3,
    "rig": {"use": "rig.monocular", "binning": 128},
    "design": {
        "focal_length_mm": {"between": [1, 20]},
        "pitch_deg": {"between": [-30, 30]},
        "sensor": {"from": "image_sensors"},
    },
    "constraints": {"hfov_deg": {"max": 140}},
    "nodes": {
        "world": {"use": "scene.toy", "frames": 3},
        "capture": {"use": "renderer.toy", "in": {"episode": "world"}},
        "frames": {"use": "sensor.toy", "in": {"capture": "capture"}},
        "width": {"use": "task.toy-width", "in": {"frames": "frames"}},
    },
    "fitness": [{"score": "width.closeness", "weight": 1}],
    "optimizer": {"use": "optimizer.genetic"},
    "study": {"renew_episodes": "never"},
    "test": {"seed": 9, "frames": 2, "episodes": 1},
}
"""A recipe as a file has it, whose sensor comes from the catalog."""


def toy_recipe(**sections: Any) -> Recipe:
    """A recipe that designs a toy, with `sections` put over it, mappings key by key."""
    base: dict[str, Any] = {
        "name": "toy",
        "seed": 3,
        "rig": {
            "use": "rig.monocular",
            "sensor": {"name": "tiny", "width_px": 16, "height_px": 8, "pixel_um": 100},
        },
        "design": {"focal_length_mm": {"between": [0.5, 5]}, "pitch_deg": {"between": [-30, 30]}},
        "nodes": {
            "world": {"use": "scene.toy"},
            "capture": {"use": "renderer.toy", "in": {"episode": "world"}},
            "frames": {"use": "sensor.toy", "in": {"capture": "capture"}},
            "width": {"use": "task.toy-width", "in": {"frames": "frames"}},
        },
        "fitness": [{"score": "width.closeness", "weight": 1}],
        "optimizer": {
            "use": "optimizer.genetic",
            "population": 6,
            "keep": 2,
            "parents": 3,
            "generations": 4,
        },
        "test": {"seed": 1001, "frames": 4, "episodes": 2},
    }
    return Recipe.model_validate(merged(base, sections))


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `changes` put over it, mappings key by key."""
    both = dict(base)
    for key, value in changes.items():
        old = both.get(key)
        both[key] = merged(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return both


def run(recipe: Recipe, toys: Plugins, out: Path, **options: Any) -> dict[str, Any]:
    """Run a recipe without its report."""
    return run_recipe(recipe, out=out, plugins=toys, report=False, **options)


def begun_as(finished: Path, out: Path) -> Path:
    """The folder of a run that broke off before any result, as `finished` was then."""
    out.mkdir()
    for name in ("recipe.yaml", "manifest.json", "run.sqlite"):
        (out / name).write_bytes((finished / name).read_bytes())
    return out


def comparable(result: Mapping[str, Any]) -> dict[str, Any]:
    """A result without what may differ between equal runs: times and the machine."""
    return {k: v for k, v in result.items() if k not in ("seconds", "seconds_by_node", "environment")}
