"""Evaluations as plain data in the files of a run, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from tacos_framework.simulation import Evaluation


def as_data(evaluation: Evaluation) -> dict[str, Any]:
    """An evaluation as plain data, without the states of tasks and the error that ended it."""
    data = asdict(replace(evaluation, states={}, raised=None))
    del data["states"], data["raised"]
    return data


def evaluation_from(data: Mapping[str, Any]) -> Evaluation:
    """The evaluation that `as_data` has made plain."""
    columns = {name: tuple(episodes) for name, episodes in data["scenario_episodes"].items()}
    return Evaluation(
        **{
            **data,
            "episodes": tuple(data["episodes"]),
            "scenario_episodes": columns,
            "episode_numbers": tuple(data["episode_numbers"]),
        }
    )
