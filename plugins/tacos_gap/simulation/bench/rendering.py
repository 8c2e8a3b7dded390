"""Expected values for captures that name a recipe instead of files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, Plugins, ProcedureRecipe, UserError, did_you_mean, read_any_recipe
from tacos_framework.plan import plan_procedure
from tacos_gap.captures.expected_values import Render
from tacos_gap.simulation.bench.settings import BenchSettings
from tacos_gap.simulation.bench.simulated import CaptureBench


def recipe_renderer(plugins: Plugins) -> Render:
    """Renderer of a capture's `scene`, as `read_captures` asks for it.

    The recipe is one of a bench, as `tacos captures simulate` takes it: a file, or the name of one that is
    shipped. Of its captures the one of the same id is rendered; a recipe with a single capture serves any id.
    """
    benches: dict[Path, CaptureBench] = {}

    def render(path: Path, capture: str) -> NDArray[np.float32]:
        if path not in benches:
            benches[path] = _bench(path, plugins)
        shots = benches[path].shots
        shot = shots.get(capture) or (next(iter(shots.values())) if len(shots) == 1 else None)
        if shot is None:
            raise UserError(
                Fault(str(path), f"it photographs no {capture!r}", "", did_you_mean(capture, shots))
            )
        return benches[path].expected(shot).signal_dn

    return render


def _bench(path: Path, plugins: Plugins) -> CaptureBench:
    recipe, faults = read_any_recipe(path if path.is_file() or path.suffix else path.name)
    if not isinstance(recipe, ProcedureRecipe):
        raise UserError(not_of_a_bench(str(path)))
    config = plan_procedure(recipe, plugins, faults).config
    if not isinstance(config, BenchSettings):
        raise UserError(not_of_a_bench(str(path)))
    return CaptureBench(config, plugins, recipe.seed)


def not_of_a_bench(name: str) -> Fault:
    return Fault(
        name,
        "this recipe does not say what to photograph",
        "use: procedure.simulate-captures",
        "Start from the shipped recipe 'bench', and give it this camera.",
    )
