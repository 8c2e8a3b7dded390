"""Files of text that users write, and examples to start from."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from tacos_framework.catalog import camera_names, find_catalog
from tacos_framework.plan import make_plan
from tacos_framework.plan.procedure import plan_procedure
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.recipe.loading import read_any_recipe
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_gap.captures import read_captures
from tacos_plugins.sensors.calibration import load_calibration
from tests.fuzz.reader import Reader

ROOT = Path(__file__).parents[2]


@cache
def _plugins() -> Plugins:
    return Plugins.discover()


def _plan(path: Path) -> object:
    recipe, faults = read_any_recipe(path)
    plan: Callable[..., object] = make_plan if isinstance(recipe, Recipe) else plan_procedure
    return plan(recipe, _plugins(), faults)


def _shipped(name: str) -> Callable[[], bytes]:
    return lambda: (ROOT / name).read_bytes()


def _first_parts(name: str, section: str, count: int) -> Callable[[], bytes]:
    """A catalog cut down to its first parts, so that reading it is quick."""

    @cache
    def made() -> bytes:
        data = read_yaml((ROOT / name).read_text("utf-8")).data
        data[section] = dict(list(data[section].items())[:count])
        return json.dumps(data).encode()

    return made


def _captures(path: Path) -> object:
    """A folder of captures whose frames are there."""
    frames = np.random.default_rng(0).integers(50, 60, (2, 4, 6)).astype(np.uint8)
    for i, frame in enumerate(frames):
        np.save(path.parent / f"{i}.npy", frame)
    return read_captures(path)


_CAPTURES = b"""\
tacos_captures: 1
camera: {width_px: 6, height_px: 4, black_level_dn: 16, crop: {x: 1, full_width_px: 8, full_height_px: 8}}
noise: [{photon_dn: 0.1, thermal_dn2: 1}]
captures:
  - {id: a, kind: sequence, real: "[0-9].npy", simulated: 55, velocity_px_s: [1, 2], frame_interval_ms: 3}
  - {id: b, kind: dark, real: [0.npy, 1.npy], exposure_ms: 3, group: g, depth: 0.npy, mask: 1.npy}
  - {id: c, kind: board, real: 0.npy, board: {inner_corners: [9, 6], square_mm: 25}}
"""

_TABLE = b"name,width_px,height_px,pixel_um,maker\na,640,480,3.5,x\nb,,1,unknown,\n"

TEXTS: Mapping[str, Reader] = {
    "captures": Reader(".yaml", _captures, lambda: _CAPTURES),
    "recipe": Reader(".yaml", _plan, _shipped("recipes/headset_quick.yaml")),
    "procedure": Reader(".yaml", _plan, _shipped("recipes/calibrate_noise.yaml")),
    "catalog": Reader(".yaml", find_catalog, _first_parts("catalogs/image_sensors.yaml", "parts", 3)),
    "table": Reader(".csv", find_catalog, lambda: _TABLE),
    "cameras": Reader(".yaml", camera_names, _first_parts("catalogs/cameras.yaml", "cameras", 2)),
    "calibration": Reader(".yaml", load_calibration, _shipped("catalogs/noise/flea3_imx172.yaml")),
}
