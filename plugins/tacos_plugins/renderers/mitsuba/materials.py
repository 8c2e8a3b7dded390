"""Materials as descriptions of Mitsuba's BSDFs, meaning what they mean to the rasterizer.

The rasterizer adds two parts: Lambertian reflection by ``base (1 - metallic)`` of what the coat lets through
towards the eye, and a GGX reflection whose reflectance at normal incidence is ``0.04 sheen (1 - metallic) +
base metallic``, where sheen falls from 1 at roughness 0.4 to 0 at 0.8. The same here is a blend of a diffuse
surface, a rough plastic (diffuse under a GGX coat of index 1.5, which is 0.04 at normal incidence) and a
rough mirror in the base colour.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Material
from tacos_framework.camera import LINEAR_OF_SRGB_BYTE
from tacos_plugins.renderers.traced.coat import sheen

Description = dict[str, Any]
"""Argument of `mitsuba.load_dict`."""

_LEAST_ALPHA = 0.01
_COAT_INDEX = 1.5


def bsdf(mitsuba: ModuleType, material: Material) -> Description:
    """Reflection of a material, from both of its sides alike."""
    colour = _loaded_colour(mitsuba, material)
    alpha = max(material.roughness**2, _LEAST_ALPHA)
    dielectric = _blend(
        sheen(material),
        {"type": "diffuse", "reflectance": colour},
        {
            "type": "roughplastic",
            "distribution": "ggx",
            "alpha": alpha,
            "int_ior": _COAT_INDEX,
            "ext_ior": 1.0,
            "diffuse_reflectance": colour,
        },
    )
    mirror = {
        "type": "roughconductor",
        "material": "none",
        "distribution": "ggx",
        "alpha": alpha,
        "specular_reflectance": colour,
    }
    surface = _blend(float(material.metallic), dielectric, mirror)
    if material.normal_map is not None:
        surface = {
            "type": "normalmap",
            "normalmap": _bitmap(mitsuba, _encoded_normals(material.normal_map)),
            "bsdf": surface,
        }
    return {"type": "twosided", "bsdf": surface}


def linear_reflectance(material: Material) -> NDArray[np.float32]:
    """(T, T, 3) linear reflectance of a textured material, base colour included [1].

    Mitsuba is given linear values: the base colour multiplies what the sRGB bytes stand for, not the bytes.
    """
    assert material.texture is not None
    linear = LINEAR_OF_SRGB_BYTE.astype(np.float32)[material.texture]
    return (linear * material.base_colour).astype(np.float32)


def _loaded_colour(mitsuba: ModuleType, material: Material) -> Any:
    """The base colour, loaded once for all parts of the BSDF that use it."""
    if material.texture is not None:
        return mitsuba.load_dict(_bitmap(mitsuba, linear_reflectance(material)))
    return mitsuba.load_dict(
        {"type": "rgb", "value": np.clip(material.base_colour, 0, 1).astype(float).tolist()}
    )


def _blend(share: float, first: Description, second: Description) -> Description:
    """`first` and `second` in the shares ``1 - share`` and `share`."""
    if share <= 0 or share >= 1:
        return second if share >= 1 else first
    return {"type": "blendbsdf", "weight": share, "first": first, "second": second}


def _bitmap(mitsuba: ModuleType, values: NDArray[np.float32]) -> Description:
    """A texture of linear values that tiles."""
    return {
        "type": "bitmap",
        "bitmap": mitsuba.Bitmap(np.ascontiguousarray(values)),
        "raw": True,
        "filter_type": "bilinear",
        "wrap_mode": "repeat",
    }


def _encoded_normals(normal_map: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Normals as Mitsuba reads them, ``2 c - 1``, of bytes in which 128 is zero and 255 one."""
    normal = (normal_map.astype(np.float32) - 128) / 127
    return (0.5 + 0.5 * normal).astype(np.float32)
