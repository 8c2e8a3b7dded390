"""Materials of glTF: metallic-roughness, emission, transmission, moved textures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera import LINEAR_OF_SRGB_BYTE
from tacos_worlds.imported.formats.gltf_buffers import Buffers, Damaged, Json
from tacos_worlds.imported.formats.pictures import picture
from tacos_worlds.imported.model import Skin


class Skins:
    """The materials of a file, each picture decoded once.

    Parameters
    ----------
    most_px
        Longest edge of textures [px].
    """

    def __init__(self, buffers: Buffers, most_px: int) -> None:
        self._buffers, self._most_px = buffers, most_px
        self._pictures: dict[int, NDArray[np.uint8]] = {}

    def all(self) -> tuple[Skin, ...]:
        """Every material of the file, and last the one of surfaces that name none."""
        return *map(self._skin, self._buffers.listed("materials")), Skin("default", np.ones(3))

    def uv_set(self, material: object) -> tuple[int, NDArray[np.float64]]:
        """Which texture coordinates a material uses, and (3, 3) how it moves them (KHR_texture_transform)."""
        if material is None:
            return 0, np.eye(3)
        info = _pbr(self._buffers.entry("materials", material)).get("baseColorTexture", {})
        moved = info.get("extensions", {}).get("KHR_texture_transform", {})
        turn, (du, dv), (su, sv) = (
            moved.get("rotation", 0.0),
            moved.get("offset", (0, 0)),
            moved.get("scale", (1, 1)),
        )
        cos, sin = math.cos(turn), math.sin(turn)
        matrix = np.array([[cos * su, sin * sv, du], [-sin * su, cos * sv, dv], [0, 0, 1]], np.float64)
        return int(moved.get("texCoord", info.get("texCoord", 0))), matrix

    def _skin(self, entry: Json) -> Skin:
        pbr, more = _pbr(entry), entry.get("extensions", {})
        factor = _numbers(pbr.get("baseColorFactor", (1, 1, 1, 1)), 4)
        image = self._texture(pbr.get("baseColorTexture"))
        opacity = 1.0
        if entry.get("alphaMode", "OPAQUE") == "BLEND":
            opacity = float(factor[3]) * (1.0 if image is None else float(image[..., 3].mean()) / 255)
        opacity *= 1.0 - float(more.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0))
        bumps = self._texture(entry.get("normalTexture"))
        glow = _numbers(entry.get("emissiveFactor", (0, 0, 0)), 3)
        if glow.any() and (glowing := self._texture(entry.get("emissiveTexture"))) is not None:
            glow = glow * LINEAR_OF_SRGB_BYTE[glowing[..., :3]].mean(axis=(0, 1))
        strength = float(more.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0))
        unlit = "KHR_materials_unlit" in more
        return Skin(
            name=str(entry.get("name", "")),
            base_colour=np.clip(factor[:3], 0, 1),
            opacity=opacity,
            texture=None if image is None else image[..., :3],
            normal_map=None if bumps is None else bumps[..., :3],
            roughness=1.0 if unlit else float(np.clip(pbr.get("roughnessFactor", 1.0), 0, 1)),
            metallic=0.0 if unlit else float(np.clip(pbr.get("metallicFactor", 1.0), 0, 1)),
            emission=glow * strength,
            two_sided=bool(entry.get("doubleSided", False)),
        )

    def _texture(self, info: object) -> NDArray[np.uint8] | None:
        if not isinstance(info, dict):
            return None
        texture = self._buffers.entry("textures", info.get("index"))
        webp = texture.get("extensions", {}).get("EXT_texture_webp", {})
        index = webp.get("source", texture.get("source"))
        if index is None:
            names = ", ".join(texture.get("extensions", {})) or "nothing"
            raise Damaged(f"a texture has its image only as {names}: export textures as PNG or JPEG")
        if index not in self._pictures:
            data = self._buffers.image(index)
            self._pictures[index] = picture(data, f"images[{index}]", self._most_px)
        return self._pictures[index]


def _pbr(entry: Json) -> dict[str, Any]:
    pbr = entry.get("pbrMetallicRoughness", {})
    return pbr if isinstance(pbr, dict) else {}


def _numbers(values: object, count: int) -> NDArray[np.float64]:
    array = np.asarray(values, np.float64)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise Damaged(f"a material has {values!r} where {count} numbers belong")
    return array
