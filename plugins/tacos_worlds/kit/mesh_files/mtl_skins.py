"""Materials of MTL libraries as skins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework import UserError
from tacos_worlds.kit.mesh_files.mtl import MtlMaterial
from tacos_worlds.kit.mesh_files.pictures import MISSING, UNSEEN_REFLECTANCE, picture
from tacos_worlds.kit.mesh_files.references import References
from tacos_worlds.kit.models.model import Skin

_HOLE = 128
"""Opacity below which one looks through [codes]."""


class MtlSkins:
    """Makes skins; each picture is decoded once, and faults of pictures are kept by the references."""

    def __init__(self, references: References, most_px: int) -> None:
        self._references, self._most_px = references, most_px
        self._pictures: dict[str, NDArray[np.uint8] | None] = {}

    def skin(self, name: str, material: MtlMaterial) -> Skin:
        """A material with its pictures.

        Roughness of Phong's exponent n is the fourth root of 2 / (n + 2) (Karis 2013, alpha = roughness^2).
        """
        pixels, mask = self.pixels(material.picture, material.library), self._mask(material)
        if mask is None and pixels is not None and (pixels[..., 3] < _HOLE).any():
            self._references.notes.append(
                f"{name}: {material.picture} has holes, but no map_d says so: it is drawn solid"
            )
        colour = np.array(material.diffuse or ((1.0,) * 3 if material.picture else (0.5,) * 3))
        if material.picture and not colour.any():
            self._references.notes.append(f"{name}: Kd 0 0 0 would make its picture black, and is left out")
            colour = np.ones(3)
        if material.picture and pixels is None:
            colour = colour * UNSEEN_REFLECTANCE
        rough = (2 / (material.shininess + 2)) ** 0.25 if material.roughness is None else material.roughness
        return Skin(
            name=name,
            base_colour=np.clip(colour, 0, 1),
            opacity=material.opacity,
            mask=mask,
            clamped=(material.clamped, material.clamped),
            texture=None if pixels is None else pixels[..., :3],
            roughness=float(np.clip(rough, 0, 1)),
            metallic=material.metallic,
            emission=np.array(material.emission),
        )

    def pixels(self, named: str, library: str) -> NDArray[np.uint8] | None:
        """(H, W, 4) a picture that a library names; None without a name, or where it cannot be read."""
        name = named and self._references.from_library(library, named)
        if name and name not in self._pictures:
            if self._references.lacks(name, MISSING):
                self._pictures[name] = None
                return None
            try:
                loaded = self._references.picture(self._references.bytes_of(name), name)
                self._pictures[name] = picture(loaded, self._most_px)
            except UserError:  # kept: all faults are told at once
                self._pictures[name] = None
        return self._pictures.get(name)

    def _mask(self, material: MtlMaterial) -> NDArray[np.uint8] | None:
        """(H, W) the alpha of map_d where it has some or is map_Kd too, else its brightness."""
        pixels = self.pixels(material.mask_picture, material.library)
        if pixels is None:
            return None
        if material.mask_picture == material.picture or (pixels[..., 3] < 255).any():
            return pixels[..., 3]
        return np.asarray(pixels[..., :3].mean(axis=2).round(), np.uint8)
