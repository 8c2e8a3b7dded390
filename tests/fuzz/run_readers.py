"""Results folders and weights that somebody sent."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from safetensors.numpy import save as save_tensors

from tacos_framework.files import read_json
from tests.fuzz.reader import Reader


@cache
def _pt() -> bytes:
    import torch

    stream = io.BytesIO()
    torch.save({"state_dict": {"a.weight": torch.ones(3, 4), "a.bias": torch.zeros(3)}}, stream)
    return stream.getvalue()


def _safetensors() -> bytes:
    return save_tensors({"a": np.ones((3, 4), np.float32)})


def _checkpoint(path: Path) -> object:
    from tacos_plugins.tasks.learning.checkpoints import read_checkpoint

    return read_checkpoint(path, where="weights")


def _study(path: Path) -> object:
    """The report's and the tables' reading of a results folder."""
    from tacos_decision.tables import read_result
    from tacos_report.study_data import read_study

    folder = path.parent / "run"
    folder.mkdir(exist_ok=True)
    (folder / "result.json").write_bytes(path.read_bytes())
    read_study(folder)
    return read_result(folder)


def _result() -> bytes:
    result = {
        "cameras": {"designed": {"title": "x", "camera": {"focal_length_mm": 4.0}, "terms": {"a": 0.5}}},
        "best": {"camera": {"focal_length_mm": 4.0}, "fitness": 0.5},
        "test": {"designed": {"a": 0.5, "fitness": 0.5}},
        "samples": {"designed": ["samples/0.png"]},
    }
    return json.dumps(result).encode()


def _sent_run(path: Path) -> object:
    """`tacos verify` and `tacos watch` of a run whose digests fit, whatever its database holds."""
    from tacos_framework.store.database import PARTS, Database
    from tacos_report.verifying import verify
    from tacos_report.watching.running_study import read_running

    kinds = read_json(path)
    folder = path.parent / "sent"
    folder.mkdir(exist_ok=True)
    (folder / "recipe.yaml").write_text(RECIPE_TEXT)
    for name in PARTS:
        (folder / name).unlink(missing_ok=True)
    with Database(folder / PARTS[0]) as database, database.transaction():
        for kind in _RUN.keys() & (kinds if isinstance(kinds, dict) else {}):
            values = kinds[kind]
            named = values.items() if isinstance(values, dict) else [(0, values)]
            for key, value in enumerate(values) if isinstance(values, list) else named:
                database.put(kind, key, value)
    read_running(folder)
    return verify(folder)


_EVALUATION: dict[str, Any] = {
    "values": {},
    "derived": {},
    "scores": {},
    "fitness": 0.5,
    "terms": {},
    "failed": None,
    "episodes": [],
    "images": 3,
    "seconds": {},
    "cached": False,
    "scenario_episodes": {},
    "scenarios": {},
    "broken": {},
    "episode_numbers": [0],
}
RECIPE_TEXT = "tacos: 1\nname: sent\noptimizer: {use: optimizer.sobol, evaluations: 4}\n"
_RUN: dict[str, Any] = {
    "checkpoint": [
        {
            "budget": None,
            "searches": {},
            "seconds": 1.0,
            "seconds_by_node": {"width": 0.5},
            "weights": {"designed.learner": "designed.learner.3"},
            "test": {"designed": _EVALUATION},
            "lines": {"generations.jsonl": 1},
        }
    ],
    "evaluations": {"a": {"seconds": 1.0, "evaluation": _EVALUATION, "weights": {}}},
    "files": {"recipe.yaml": "0" * 32, "samples/designed_0.png": "0" * 32},
    "generations.jsonl": [
        {"generation": 0, "seconds": 1.0, "frames": 3, "candidates": [{"fitness": 0.5}], "best": None}
    ],
}


def _run() -> bytes:
    return json.dumps(_RUN).encode()


RUNS: Mapping[str, Reader] = {
    "safetensors": Reader(".safetensors", _checkpoint, _safetensors, whole_or_fault=True),
    "torch": Reader(".pt", _checkpoint, _pt, whole_or_fault=True),
    "json": Reader(".json", read_json, _result, "json", whole_or_fault=True),
    "run": Reader(".json", _sent_run, _run, "json", whole_or_fault=True),
    "result": Reader(".json", _study, _result, "json", whole_or_fault=True),
}
