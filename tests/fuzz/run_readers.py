"""Results folders and weights that somebody sent."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

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


RUNS: Mapping[str, Reader] = {
    "safetensors": Reader(".safetensors", _checkpoint, _safetensors, whole_or_fault=True),
    "torch": Reader(".pt", _checkpoint, _pt, whole_or_fault=True),
    "json": Reader(".json", read_json, _result, "json", whole_or_fault=True),
    "result": Reader(".json", _study, _result, "json", whole_or_fault=True),
}
