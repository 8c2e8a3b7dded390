"""A file as patches of surface in metres with z up, and everything that is wrong with it, at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_worlds.imported.doubts import likely_unit
from tacos_worlds.imported.labels import Rule
from tacos_worlds.kit.models.cutouts import cut_out, without_clear
from tacos_worlds.kit.models.hulls import without_hulls
from tacos_worlds.kit.models.model import Model, Surface

_FAR_M = 1000.0
"""Single precision holds positions to 0.06 mm up to here [m]."""
_LOWEST_M, _WIDEST_M = 1.5, 20_000.0

_Z_UP_FROM: dict[str, NDArray[np.float64]] = {
    "x": np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]),
    "y": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "z": np.eye(3),
}


@dataclass(frozen=True, eq=False)
class Read:
    """A model, and how its axes and unit become metres with z up."""

    model: Model  # without what is to be left out
    turn: NDArray[np.float64]  # (3, 3) from the file's coordinates to metres with z up
    up: str  # the axis that was taken as up
    origin_m: NDArray[np.float64]
    """(3,) what was taken off positions, in metres with z up, so that single precision holds them [m]."""


def read_world(
    file: Path,
    *,
    up: Literal["auto", "x", "y", "z"],
    metres_per_unit: float,
    leave_out: tuple[str, ...],
    most_px: int,
    glass: Literal["clear", "solid"] = "clear",
) -> Read:
    """Read a file. Raises UserError with a fault for each thing that is wrong with it."""
    from tacos_worlds.kit.mesh_files import content_faults, read_model  # late: checks do without it

    model = read_model(file, most_px=most_px)
    rules = [Rule(pattern, "") for pattern in leave_out]
    kept = [s for s in model.surfaces if all(rule.matches(s.path) is None for rule in rules)]
    faults = [
        Fault(f"leave_out: {rule.pattern}", "matches nothing in the file", remedy=_names(model.surfaces))
        for rule in rules
        if all(rule.matches(s.path) is None for s in model.surfaces)
    ]
    model = without_clear(without_hulls(replace(model, surfaces=tuple(kept))), solid=glass == "solid")
    faults += content_faults(model, str(file))
    if faults:
        raise UserError(faults)
    axis = up if up != "auto" else model.up or likely_up(model)
    turn = metres_per_unit * _Z_UP_FROM[axis]
    if faults := list(_of_size(file, model, turn, metres_per_unit)):
        raise UserError(faults)
    model = cut_out(model)
    if not model.triangle_count:
        raise UserError(Fault(str(file), "holds no triangles that hide anything", "surfaces that are opaque"))
    origin_m = far_origin_m(model, turn)
    return Read(_moved(model, np.asarray(np.linalg.solve(turn, origin_m), np.float64)), turn, axis, origin_m)


def far_origin_m(model: Model, turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3,) the middle of a world in whole metres, where it lies so far off that positions would be rounded.

    Georeferenced files (UTM, ECEF) have coordinates of 10^6 m, of which single precision keeps half a metre.
    """
    lower, upper = _bounds(model, turn)
    middle = np.round((lower + upper) / 2)
    return middle if np.abs(middle).max() > _FAR_M else np.zeros(3)


def _moved(model: Model, origin: NDArray[np.float64]) -> Model:
    if not origin.any():
        return model
    return replace(
        model,
        surfaces=tuple(replace(s, vertices=s.vertices - origin) for s in model.surfaces),
        lights=tuple(replace(light, position=light.position - origin) for light in model.lights),
    )


def _bounds(model: Model, turn: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    corners = [s.vertices @ turn.T for s in model.surfaces if len(s.vertices)]
    lower = np.min([each.min(axis=0) for each in corners], axis=0)
    upper = np.max([each.max(axis=0) for each in corners], axis=0)
    return lower, upper


def likely_up(model: Model) -> Literal["y", "z"]:
    """The axis along which most of the area faces: floors and ceilings are larger than any one wall."""
    facing = area_along(model)
    return "z" if facing[2] >= facing[1] else "y"


def area_along(model: Model) -> NDArray[np.float64]:
    """(4,) area that faces along each axis of the file, within 15 degrees, and all of it [square units]."""
    facing = np.zeros(4)
    for surface in model.surfaces:
        a, b, c = (surface.vertices[surface.triangles[:, corner]] for corner in range(3))
        cross = np.cross(b - a, c - a)
        area = np.linalg.norm(cross, axis=1)
        along = np.abs(cross) > 0.966 * np.maximum(area, 1e-30)[:, None]
        facing[:3] += (along * area[:, None]).sum(axis=0) / 2
        facing[3] += area.sum() / 2
    return facing


def _of_size(file: Path, model: Model, turn: NDArray[np.float64], metres_per_unit: float) -> Iterator[Fault]:
    """Worlds nobody can walk in: the unit is another one."""
    lower, upper = _bounds(model, turn)
    extent = upper - lower
    widest = float(extent[:2].max())
    said = " x ".join(f"{length:.3g}" for length in extent)
    unit = likely_unit(float(extent[2]), metres_per_unit)
    likely = f"Its height is that of a room in {unit}." if unit else ""
    if widest < _LOWEST_M:
        yield Fault(
            f"{file}: metres_per_unit",
            f"the world is {said} m large, too small to walk in",
            "metres for one unit of the file",
            likely or f"See its program: {widest:.3g} units across is no size of buildings.",
        )
    if widest > _WIDEST_M or (float(extent[2]) > 1000.0):
        yield Fault(
            f"{file}: metres_per_unit",
            f"the world is {said} m large",
            f"at most {_WIDEST_M:g} m, and 1000 m high",
            likely
            or "Give 0.01 for a file in centimetres (Unreal's OBJ and PLY), 0.001 for millimetres, 0.0254 "
            "for inches.",
        )


def _names(surfaces: tuple[Surface, ...]) -> str:
    names = sorted({surface.path[0] if len(surface.path) == 1 else surface.path[-2] for surface in surfaces})
    shown = ", ".join(names[:12])
    return f"Names in the file: {shown}{', ...' if len(names) > 12 else ''}." if names else ""
