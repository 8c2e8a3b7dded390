"""Materials of glTF: metallic-roughness, emission, transmission, moved textures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import UserError
from tacos_framework.camera import LINEAR_OF_SRGB_BYTE
from tacos_worlds.kit.mesh_files.damage import Damaged
from tacos_worlds.kit.mesh_files.gltf_buffers import Buffers, Json
from tacos_worlds.kit.mesh_files.gltf_notes import SPECULAR_GLOSSINESS, remedy_for
from tacos_worlds.kit.mesh_files.packed import BASISU
from tacos_worlds.kit.mesh_files.pictures import MISSING, UNSEEN_REFLECTANCE, picture
from tacos_worlds.kit.models.model import Skin

_REPEATED, _CLAMPED, _MIRRORED, _NEAREST = 10497, 33071, 33648, 9728
_SHARP_PX = 1024
"""Textures of hard texels are enlarged to about this [px]."""
_BLACK, _BRIGHT = 0.04, 0.25
"""Specular-glossiness says metals by a diffuse colour below and a specular one above [1]."""


class Skins:
    """The materials of a file, each picture decoded once. `most_px`: longest edge of textures [px]."""

    def __init__(self, buffers: Buffers, most_px: int) -> None:
        self._buffers, self._most_px = buffers, most_px
        self._pictures: dict[int, NDArray[np.uint8] | None] = {}

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
        for axis, wrap in enumerate(self._wraps(info)):
            if wrap == _MIRRORED:  # the texture is kept with its mirror image
                matrix[axis] /= 2
        return int(moved.get("texCoord", info.get("texCoord", 0))), matrix

    def _skin(self, entry: Json) -> Skin:
        pbr, more = _pbr(entry), entry.get("extensions", {})
        factor = _numbers(pbr.get("baseColorFactor", (1, 1, 1, 1)), 4)
        image = self._texture(pbr.get("baseColorTexture"))
        opacity, mask, cutoff = _opacity(entry, float(factor[3]), image)
        opacity *= 1.0 - float(more.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0))
        wraps = self._wraps(pbr.get("baseColorTexture", {}))
        if image is not None:
            image = _doubled(self._sharp(image, pbr["baseColorTexture"]), wraps)
            mask = None if mask is None else image[..., 3]
        elif "baseColorTexture" in pbr:
            factor = factor * UNSEEN_REFLECTANCE
        bumps = self._texture(entry.get("normalTexture"))
        glow = _numbers(entry.get("emissiveFactor", (0, 0, 0)), 3)
        if glow.any() and (glowing := self._texture(entry.get("emissiveTexture"))) is not None:
            glow = glow * LINEAR_OF_SRGB_BYTE[glowing[..., :3]].mean(axis=(0, 1))
        strength = float(more.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0))
        rough, metal = self._mean_roughness(pbr)
        unlit = "KHR_materials_unlit" in more
        return Skin(
            name=str(entry.get("name", "")),
            base_colour=np.clip(factor[:3], 0, 1),
            mask=mask,
            cutoff=cutoff,
            clamped=(wraps[0] == _CLAMPED, wraps[1] == _CLAMPED),
            opacity=opacity,
            texture=None if image is None else image[..., :3],
            normal_map=None if bumps is None or unlit else _doubled(bumps, wraps)[..., :3],
            roughness=1.0 if unlit else float(np.clip(rough, 0, 1)),
            metallic=0.0 if unlit else float(np.clip(pbr.get("metallicFactor", 1.0) * metal, 0, 1)),
            emission=glow * strength * (not unlit),
            two_sided=bool(entry.get("doubleSided", False)),
            unlit=unlit,
        )

    def _mean_roughness(self, pbr: Json) -> tuple[float, float]:
        """Roughness, and the mean of a texture of metalness, over the whole surface [1]."""
        factor = float(pbr.get("roughnessFactor", 1.0))
        if (mixed := self._texture(pbr.get("metallicRoughnessTexture"))) is not None:
            rough, metal = mixed[..., 1:3].mean(axis=(0, 1)) / 255
            return factor * float(rough), float(metal)
        if (glossiness := self._texture(pbr.get("glossinessTexture"))) is not None:
            return 1 - (1 - factor) * float(glossiness[..., 3].mean()) / 255, 1.0
        return factor, 1.0

    def _sampler(self, info: object) -> Json:
        if not isinstance(info, dict) or "index" not in info:
            return {}
        texture = self._buffers.entry("textures", info["index"])
        return self._buffers.entry("samplers", texture["sampler"]) if "sampler" in texture else {}

    def _wraps(self, info: object) -> tuple[int, int]:
        sampler = self._sampler(info)
        return sampler.get("wrapS", _REPEATED), sampler.get("wrapT", _REPEATED)

    def _sharp(self, image: NDArray[np.uint8], info: object) -> NDArray[np.uint8]:
        """A texture whose texels stay squares seen from near, enlarged so that blending shows little."""
        if self._sampler(info).get("magFilter") != _NEAREST:
            return image
        times = max(1, _SHARP_PX // max(image.shape[:2]))
        return np.repeat(np.repeat(image, times, axis=0), times, axis=1)

    def _texture(self, info: object) -> NDArray[np.uint8] | None:
        if not isinstance(info, dict):
            return None
        texture = self._buffers.entry("textures", info.get("index"))
        more = texture.get("extensions", {})
        basis = more.get(BASISU, {}).get("source")
        index = more.get("EXT_texture_webp", {}).get("source", texture.get("source", basis))
        if index is None:
            names = [*more] or ["nothing"]
            raise Damaged(f"a texture has its image only as {', '.join(names)}: {remedy_for(names[0])}")
        if index not in self._pictures:
            uri = str(self._buffers.entry("images", index).get("uri", "data:"))
            if self._buffers.references.lacks(uri, MISSING, quoted=True):
                self._pictures[index] = None
                return None
            try:
                loaded = self._buffers.references.picture(self._buffers.image(index), f"picture {index}")
            except UserError:  # kept among the faults of the references: all are told at once
                return None
            self._pictures[index] = picture(loaded, self._most_px)
        return self._pictures[index]


def _pbr(entry: Json) -> dict[str, Any]:
    """A material by metallic-roughness, also where it is only said by specular-glossiness."""
    pbr = entry.get("pbrMetallicRoughness")
    glossy = entry.get("extensions", {}).get(SPECULAR_GLOSSINESS)
    if not isinstance(glossy, dict) or pbr:
        return pbr if isinstance(pbr, dict) else {}
    return _from_specular_glossiness(glossy)


def _from_specular_glossiness(glossy: Json) -> dict[str, Any]:
    """Diffuse colour as base colour; a metal where there is none, but a bright and specular one."""
    converted = {
        "baseColorFactor": glossy.get("diffuseFactor", (1, 1, 1, 1)),
        "roughnessFactor": 1.0 - float(glossy.get("glossinessFactor", 1.0)),
        "metallicFactor": 0.0,
        "glossinessTexture": glossy.get("specularGlossinessTexture"),
    }
    if "diffuseTexture" in glossy:
        converted["baseColorTexture"] = glossy["diffuseTexture"]
    factor = _numbers(converted["baseColorFactor"], 4)
    mirror = _numbers(glossy.get("specularFactor", (1, 1, 1)), 3)
    if factor[:3].max() < _BLACK and mirror.max() > _BRIGHT:
        converted |= {"baseColorFactor": (*mirror, factor[3]), "metallicFactor": 1.0}
        converted.pop("baseColorTexture", None)
        if "specularGlossinessTexture" in glossy:
            converted["baseColorTexture"] = glossy["specularGlossinessTexture"]
    return converted


def _opacity(
    entry: Json, factor: float, image: NDArray[np.uint8] | None
) -> tuple[float, NDArray[np.uint8] | None, float]:
    """How much of what lies behind is hidden on the whole, and the mask of what is there, with its cutoff.

    What is blended is drawn whole or not at all: by a mask where it has holes and more, else as a whole.
    """
    mode = entry.get("alphaMode", "OPAQUE")
    if mode == "OPAQUE":
        return 1.0, None, 0.5
    cutoff = float(entry.get("alphaCutoff", 0.5)) if mode == "MASK" else 0.5
    if image is None:
        return (factor if mode == "BLEND" else float(factor >= cutoff)), None, cutoff
    least = cutoff / max(factor, 1e-6)
    there = image[..., 3] >= 255 * least
    if there.all() or not there.any():
        return (
            (factor * float(image[..., 3].mean()) / 255 if mode == "BLEND" else float(there.all())),
            None,
            cutoff,
        )
    return 1.0, image[..., 3], least


def _doubled(image: NDArray[np.uint8], wraps: tuple[int, int]) -> NDArray[np.uint8]:
    """An image beside its mirror image along each axis that mirrors."""
    if wraps[0] == _MIRRORED:
        image = np.concatenate([image, image[:, ::-1]], axis=1)
    return np.concatenate([image[::-1], image], axis=0) if wraps[1] == _MIRRORED else image


def _numbers(values: object, count: int) -> NDArray[np.float64]:
    array = np.asarray(values, np.float64)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise Damaged(f"a material has {values!r} where {count} numbers belong")
    return array
