"""Collision hulls of game engines, which no camera sees.

Source: Epic Games, Unreal Engine documentation, "FBX Static Mesh Pipeline", collision.
"""

from __future__ import annotations

import re
from dataclasses import replace

from tacos_worlds.kit.models.model import Model

_HULL = re.compile("U(?:BX|CP|SP|CX)_")


def without_hulls(model: Model) -> Model:
    """The model without surfaces that are named as collision hulls, which is told; hulls alone are kept."""
    hulls = {id(s): name for s in model.surfaces for name in s.path if _HULL.match(name)}
    if len(hulls) in (0, len(model.surfaces)):
        return model
    names = sorted(set(hulls.values()))
    shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
    kept = tuple(surface for surface in model.surfaces if id(surface) not in hulls)
    note = f"{shown}: collision hulls (UBX_, UCP_, USP_, UCX_) are left out"
    return replace(model, surfaces=kept, notes=(*model.notes, note))
