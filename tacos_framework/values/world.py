"""A world: surfaces, materials, lights and labels. Metres; right-handed; z is up."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tacos_framework.values.arrays import read_only


@dataclass(frozen=True, eq=False)
class Material:
    """Reflection and emission of a surface (metallic-roughness model)."""

    name: str
    """For logs and exports."""
    base_colour: NDArray[np.float32]
    """(3,) float32 linear sRGB reflectance in 0..1 [1]; multiplies the texture."""
    texture: NDArray[np.uint8] | None = None
    """(T, T, 3) uint8 sRGB base colour that tiles, T a power of two, row 0 at the bottom (v = 0); or None."""
    texture_size_m: float = 1.0
    """Edge of one tile [m]."""
    normal_map: NDArray[np.uint8] | None = None
    """(T, T, 3) uint8 tangent-space normals (x along u, y along v; 128 is zero), same T; or None."""
    roughness: float = 0.8
    metallic: float = 0.0
    """0..1 [1]."""
    emission_cd_m2: NDArray[np.float32] = field(default_factory=lambda: np.zeros(3, np.float32))
    """(3,) float32 luminance the surface emits itself [cd/m2]."""
    unlit: bool = False
    """True if its colour was photographed with its light: `World.indirect_lux` alone falls on it, without
    shadows, which is the same all over it.
    """

    def __post_init__(self) -> None:
        read_only(self, "base_colour", np.float32, (3,))
        read_only(self, "emission_cd_m2", np.float32, (3,))
        for name in ("texture", "normal_map"):
            if (image := getattr(self, name)) is not None:
                size = len(image)
                if size & (size - 1):
                    raise ValueError(f"{name} of material {self.name!r} is {size} px, not a power of two")
                read_only(self, name, np.uint8, (size, size, 3))


@dataclass(frozen=True, eq=False)
class MeshPart:
    """A triangle mesh in world coordinates, of one material, belonging to one object."""

    vertices_m: NDArray[np.float32]
    """(V, 3) float32 [m]."""
    normals: NDArray[np.float32]
    """(V, 3) float32, unit length."""
    uv_m: NDArray[np.float32]
    """(V, 2) float32 texture coordinates in metres along the surface [m]."""
    triangles: NDArray[np.int32]
    """(T, 3) int32 indices of vertices, counter-clockwise seen from outside."""
    material: int
    """Index into `World.materials`."""
    object_id: int
    """Id of the object it belongs to: index into `World.objects`."""
    light_detail: float = 1.0
    """Fineness of the light on it, over what a renderer is asked for: below 1 for what is only
    seen from afar [1].
    """

    def __post_init__(self) -> None:
        read_only(self, "vertices_m", np.float32, (None, 3))
        count = len(self.vertices_m)
        read_only(self, "normals", np.float32, (count, 3))
        read_only(self, "uv_m", np.float32, (count, 2))
        read_only(self, "triangles", np.int32, (None, 3))
        if not self.light_detail > 0:
            raise ValueError(f"light_detail of a part must be above 0, not {self.light_detail}")


@dataclass(frozen=True)
class Object:
    """A labelled thing."""

    name: str
    """For logs and exports."""
    class_name: str
    """One of `World.class_names`."""
    moves: bool = field(default=False, repr=False)
    """True if episodes move it (`Episode.movers`): it is lit where it rests, and casts no shadow."""


@dataclass(frozen=True, eq=False)
class Light:
    """A diffuse rectangular emitter, or a small sphere where `normal` is None."""

    position_m: NDArray[np.float32]
    """(3,) centre [m]."""
    flux_lm: NDArray[np.float32]
    """(3,) luminous flux per linear sRGB channel, scaled so that white light has equal channels [lm]."""
    normal: NDArray[np.float32] | None = None
    """(3,) unit vector into which it shines (Lambertian), or None: all directions alike."""
    half_u_m: NDArray[np.float32] = field(default_factory=lambda: np.zeros(3, np.float32))
    half_v_m: NDArray[np.float32] = field(default_factory=lambda: np.zeros(3, np.float32))
    """(3,) vectors from the centre to the middle of two edges [m]; zero for a sphere."""
    radius_m: float = 0.05
    """Radius of a sphere [m]."""

    def __post_init__(self) -> None:
        for name in ("position_m", "flux_lm", "half_u_m", "half_v_m"):
            read_only(self, name, np.float32, (3,))
        if self.normal is not None:
            read_only(self, "normal", np.float32, (3,))


@dataclass(frozen=True, eq=False)
class World:
    """Everything that can be seen and what lights it.

    Object 0 is the background: what belongs to no labelled thing (walls, floor, sky).
    """

    key: str
    """Content key: equal keys mean equal worlds; renderers upload and bake once per key."""
    parts: tuple[MeshPart, ...]
    materials: tuple[Material, ...]
    objects: tuple[Object, ...]
    class_names: tuple[str, ...]
    lights: tuple[Light, ...] = ()
    indirect_lux: tuple[NDArray[np.float32], ...] | None = None
    """One (V, 3) float32 array per part: light that reaches each vertex after at least one reflection, as
    irradiance per channel [lux]; None where a renderer should bake it itself.
    """
    ambient_cd_m2: NDArray[np.float32] = field(default_factory=lambda: np.zeros(3, np.float32))
    """(3,) luminance of whatever lies beyond the geometry [cd/m2]."""
    sky_cd_m2: NDArray[np.float32] | None = None
    """(H, 2 H, 3) float32 what is seen beyond the geometry, where it is not `ambient_cd_m2` all around: rows
    from the zenith down to the nadir, columns from +x by way of +y. Its mean, weighted by the cosine from
    the zenith, should be `ambient_cd_m2`, which lights surfaces [cd/m2]. None for even surroundings.
    """
    origin_m: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    """(3,) float64 where its origin lies in the coordinates of the file it was read from, of which single
    precision would keep too little; zero for most worlds [m].
    """
    remarks: tuple[str, ...] = ()
    """Doubts about its files, and statements in them that are not carried out, with the effect."""
    unscaled: World | None = field(default=None, repr=False)
    light_factor: float = 1.0
    """The same world in other light, with a content key of its own, and by how much stronger all light is
    here [1]. Light is linear: what was worked out for the one holds for the other, times this factor.
    """

    def __post_init__(self) -> None:
        read_only(self, "origin_m", np.float64, (3,))
        read_only(self, "ambient_cd_m2", np.float32, (3,))
        if self.sky_cd_m2 is not None:
            rows = len(self.sky_cd_m2)
            read_only(self, "sky_cd_m2", np.float32, (rows, 2 * rows, 3))
        if not self.objects:
            raise ValueError("a world needs object 0, the background")
        unknown = {thing.class_name for thing in self.objects} - set(self.class_names)
        if unknown:
            raise ValueError(f"objects of unknown class: {', '.join(sorted(unknown))}")
        for part in self.parts:
            if not 0 <= part.material < len(self.materials) or not 0 <= part.object_id < len(self.objects):
                raise ValueError(
                    f"a part names material {part.material} and object {part.object_id}, "
                    f"but there are {len(self.materials)} and {len(self.objects)}"
                )

    @property
    def triangle_count(self) -> int:
        return sum(len(part.triangles) for part in self.parts)

    @property
    def nbytes(self) -> int:
        of_parts = (part.vertices_m.nbytes * 8 // 3 + part.triangles.nbytes for part in self.parts)
        images = {id(image): image for m in self.materials for image in (m.texture, m.normal_map)}
        maps = (image.nbytes for image in images.values() if image is not None)
        sky = 0 if self.sky_cd_m2 is None else self.sky_cd_m2.nbytes
        return sum(of_parts) + sum(maps) + sum(lux.nbytes for lux in self.indirect_lux or ()) + sky

    @property
    def class_of_object(self) -> NDArray[np.int32]:
        """(objects,) int32: for each object id, the index of its class in `class_names`."""
        index = {name: i for i, name in enumerate(self.class_names)}
        return np.array([index[thing.class_name] for thing in self.objects], dtype=np.int32)
