"""A module and its optimizer as named arrays, and back, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from tacos_framework import State

MODEL = "model."
"""Begins the names of a module's entries in a state."""

MOMENTS = ("exp_avg", "exp_avg_sq")
"""Moments that Adam keeps of each parameter, beside its number of steps."""


def state_of(module: nn.Module, adam: torch.optim.Adam | None = None, *, schedule_steps: int = 0) -> State:
    """All that a module and its optimizer have learnt, as arrays of their own.

    - `module`: its parameters and buffers become ``model.NAME``.
    - `adam`: its moments become ``adam.exp_avg.NAME`` and ``adam.exp_avg_sq.NAME``, the steps of all its
      parameters ``adam.step``. One that has not begun gives zeros, so a state keeps its names and shapes for
      life.
    - `schedule_steps`: steps of the learning-rate schedule so far.

    Returns: arrays of the tensors' own types. Scalars have the shape (1,), since safetensors keeps no others.
    """
    state: dict[str, NDArray[Any]] = {MODEL + name: _array(t) for name, t in module.state_dict().items()}
    state["schedule.steps"] = np.array([schedule_steps], np.int64)
    if adam is not None:
        steps = []
        for name, parameter in _optimised(module, adam).items():
            kept = adam.state.get(parameter, {})
            steps.append(float(kept.get("step", 0)))
            for moment in MOMENTS:
                state[f"adam.{moment}.{name}"] = _array(kept.get(moment, torch.zeros_like(parameter)))
        state["adam.step"] = np.array(steps, np.float32)
    return state


def restore(state: State, module: nn.Module, adam: torch.optim.Adam | None = None) -> int:
    """Bring a module and its optimizer to a state given by `state_of`; they share no memory with it.

    Returns: steps of the learning-rate schedule so far.
    """
    module.load_state_dict(
        {
            name: torch.tensor(state[MODEL + name]).reshape(tensor.shape)
            for name, tensor in module.state_dict().items()
        }
    )
    if adam is not None:
        parameters = _optimised(module, adam)
        for (name, parameter), step in zip(parameters.items(), state["adam.step"], strict=True):
            if step > 0:
                adam.state[parameter] = {
                    "step": torch.tensor(step),
                    **{m: _like(parameter, state[f"adam.{m}.{name}"]) for m in MOMENTS},
                }
    return int(state["schedule.steps"][0])


def fresh_state(tensors: Mapping[str, Tensor], module: nn.Module) -> State:
    """The state of a module that has these entries and an Adam over its parameters that has not begun."""
    module.load_state_dict(dict(tensors))
    return state_of(module, torch.optim.Adam(p for p in module.parameters() if p.requires_grad))


def _optimised(module: nn.Module, adam: torch.optim.Adam) -> dict[str, nn.Parameter]:
    """The parameters an optimizer moves, by name, in the module's order."""
    moved = {id(parameter) for group in adam.param_groups for parameter in group["params"]}
    return {name: p for name, p in module.named_parameters() if id(p) in moved}


def _array(tensor: Tensor) -> NDArray[Any]:
    return np.array(tensor.detach().cpu().numpy(), ndmin=1)


def _like(parameter: nn.Parameter, array: NDArray[Any]) -> Tensor:
    return torch.tensor(array, device=parameter.device).reshape(parameter.shape)
