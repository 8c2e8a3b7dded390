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
    """`tacos verify` and `tacos watch` of a run whose checksums fit, whatever its files hold."""
    from tacos_framework.results.checksums import (
        json_with_checksum,
        lines_with_checksums,
        text_with_checksum,
    )
    from tacos_report.verifying import verify
    from tacos_report.watching.running_study import read_running

    files = read_json(path)
    folder = path.parent / "sent"
    folder.mkdir(exist_ok=True)
    for name, content in files.items() if isinstance(files, dict) else ():
        if name not in _RUN:
            continue
        if isinstance(content, dict):
            (folder / name).write_bytes(json_with_checksum(content))
        elif isinstance(content, list):
            lines = [line for line in content if isinstance(line, dict)]
            (folder / name).write_bytes(lines_with_checksums(lines))
        else:
            (folder / name).write_text(text_with_checksum(str(content)), "utf-8", "replace")
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
_RUN: dict[str, Any] = {
    "recipe.yaml": "tacos: 1\nname: sent\noptimizer: {use: optimizer.sobol, evaluations: 4}\n",
    "manifest.json": {"python": "3.11.7", "packages": {}, "code": {}, "catalogs": {}, "files": {}},
    "checkpoint.json": {
        "format": 4,
        "budget": None,
        "searches": {},
        "seconds": 1.0,
        "seconds_by_node": {"width": 0.5},
        "weights": {"designed.learner": ["designed.learner.3", "0" * 32]},
        "test": {"designed": _EVALUATION},
        "lines": {"generations.jsonl": {"lines": 1, "checksum": "0" * 32}},
        "samples": {"samples/designed_0.png": "0" * 32},
    },
    "journal.jsonl": [{"job": "a", "seconds": 1.0, "evaluation": _EVALUATION, "weights": {}}],
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
