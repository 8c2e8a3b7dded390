"""What is wrong with a file of triangles."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import numpy as np

from tacos_framework import Fault, UserError
from tacos_framework.files import limits
from tacos_worlds.kit.models.model import Model


class Damaged(ValueError):
    """A file is not what its format says; the message says where."""


UNREADABLE = (
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    AssertionError,
    ArithmeticError,
    OSError,
    EOFError,
    NotImplementedError,
    RecursionError,
    MemoryError,
    struct.error,
    DeprecationWarning,  # np.fromstring, of text that is no numbers: it leaves out what follows
)
"""What readers raise on files that are damaged, wherever the damage trips them."""


def refuse_triangles(where: str, count: int, most: int | None) -> None:
    """Raise where there are more triangles than a user of the file takes, or than memory is meant to hold."""
    allowed = limits().mesh_triangles if most is None else most
    if count > allowed:
        remedy = limits().remedy("mesh_triangles", count) if most is None else "Simplify the model."
        what = f"has at least {count} triangles"
        raise UserError(Fault(where, what, f"at most {allowed:.0f}", remedy))


def points_alone(where: str, count: int) -> UserError:
    """The refusal of a file of points that no faces connect."""
    remedy = "Make a mesh of them (Poisson reconstruction in MeshLab or CloudCompare) and export that."
    return UserError(Fault(where, f"is a cloud of {count} points, without faces", "a mesh", remedy))


def content_faults(model: Model, where: str) -> Iterator[Fault]:
    """What of a model's numbers no world can be made of."""
    if not model.triangle_count:
        yield Fault(where, "holds no triangles that hide anything", "a mesh of surfaces that are opaque")
    for surface in model.surfaces:
        name = f"{where}: {surface.name}"
        if surface.vertices.shape[1:] != (3,) or surface.triangles.shape[1:] != (3,):
            yield Fault(name, "has vertices or triangles that are not of three numbers")
            continue
        if bad := int((~np.isfinite(surface.vertices).all(axis=1)).sum()):
            yield Fault(name, f"has {bad} vertices that are not finite numbers")
        for what in ("normals", "uv", "colours"):
            values = getattr(surface, what)
            if values is not None and len(values) != len(surface.vertices):
                yield Fault(name, f"has {len(values)} {what} for {len(surface.vertices)} vertices")
        if surface.uv is not None and not np.isfinite(surface.uv).all():
            yield Fault(name, "has texture coordinates that are not finite numbers")
        if not 0 <= surface.skin < len(model.skins):
            yield Fault(name, f"names material {surface.skin} of {len(model.skins)}")
        used = surface.triangles
        if len(used) and not 0 <= used.min() <= used.max() < len(surface.vertices):
            yield Fault(name, "names vertices that do not exist")
