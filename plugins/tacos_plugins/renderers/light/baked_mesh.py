"""A world with its light worked out: a mesh lit per vertex, and a light map for large flat surfaces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tacos_framework import World
from tacos_plugins.coincident_faces import other_sides
from tacos_plugins.renderers.light.ambient_visibility import near_ambient_visibility
from tacos_plugins.renderers.light.charts import Charts, find_charts
from tacos_plugins.renderers.light.direct_light import LightAtPoints, direct_light
from tacos_plugins.renderers.light.flatten import (
    Chunks,
    FlatMesh,
    SurfaceKind,
    cut_into_chunks,
    flatten,
    kind_of,
    movers,
)
from tacos_plugins.renderers.light.rays import RayTracer
from tacos_plugins.renderers.light.surfaces import closed_parts, smooth_surfaces
from tacos_plugins.renderers.light.tangents import tangent_frames

LIFT_M = 2e-3
"""Points are lifted off their own surface by this before rays are traced [m]."""

_GROWTH_TEXELS = 3  # light is grown beyond the surface by these, for interpolation at its edges


@dataclass(frozen=True, eq=False)
class SurfaceLight:
    """Light that N surface points send back, as a white texture would."""

    luminance_cd_m2: NDArray[np.float32]
    """(N, 3) float32 reflected luminance for a texture of reflectance 1, base colour included [cd/m2]."""
    unshadowed_share: NDArray[np.float32]
    """(N,) float32 share of all light that shadows leave [1]."""
    bend: NDArray[np.float32]
    """(N, 2) float32 relative change of that luminance per unit of tilt of the normal along the tangent and
    the bitangent [1].
    """


@dataclass(frozen=True, eq=False)
class BakedMesh:
    """A world ready to be drawn, whatever the camera."""

    mesh: FlatMesh
    """Triangles in the order of the chunks; vertices of light-mapped surfaces are not shared with others."""
    frames: NDArray[np.float32]
    """(V, 2, 3) float32 tangent and bitangent at each vertex [1]."""
    chunks: Chunks
    surface: NDArray[np.int32]
    """(V,) int32 the smooth surface each vertex belongs to, from 1."""
    vertex_light: SurfaceLight
    """Light per vertex; nothing for vertices on the light map."""
    map_coordinates: NDArray[np.float32]
    """(V, 2) float32 light map coordinates; a black texel for vertices that are lit themselves [1]."""
    light_map: NDArray[np.float32]
    """(rows, columns, 4) float32: luminance as in `SurfaceLight` [cd/m2] and unshadowed share [1]."""
    bend_map: NDArray[np.float32]
    """(rows, columns, 2) float32: bend as in `SurfaceLight` [1]."""
    opaque: NDArray[np.intp]
    """(O,) the triangles that block light."""

    @property
    def tangents(self) -> NDArray[np.float32]:
        """(V, 4) tangent at each vertex, and the sign of its bitangent [1]."""
        tangent, bitangent = self.frames[:, 0], self.frames[:, 1]
        side = np.einsum("ij,ij->i", np.cross(self.mesh.normal, tangent), bitangent)
        return np.column_stack([tangent, np.where(side < 0, -1, 1)]).astype(np.float32)

    @cached_property
    def tracer(self) -> RayTracer:
        """The opaque triangles, for further rays."""
        return RayTracer(self.mesh.corners_m[self.opaque])


def light_world(world: World, indirect_lux: tuple[NDArray[np.float32], ...], texel_m: float) -> BakedMesh:
    """Flatten a world and work out the light on all its surfaces.

    `indirect_lux`: indirect irradiance at the vertices of each part [lux]. `texel_m`: distance of light map
    texels [m].
    """
    mesh = flatten(world, indirect_lux)
    charts = find_charts(mesh, texel_m)
    kind = np.array([kind_of(m) for m in world.materials], np.int32)[mesh.material[mesh.triangles[:, 0]]]
    kind |= np.where(charts.of_triangle >= 0, SurfaceKind.MAPPED, 0).astype(np.int32)
    one_sided = closed_parts(mesh)[mesh.part] | (other_sides(mesh.corners_m) >= 0)
    kind |= np.where(one_sided, SurfaceKind.CLOSED, 0).astype(np.int32)
    mover = movers(world, mesh)
    order, chunks = cut_into_chunks(mesh, kind, mover)
    mover = mover[order]
    mesh = replace(mesh, triangles=mesh.triangles[order], part=mesh.part[order])
    charts = replace(charts, of_triangle=charts.of_triangle[order])
    mesh, chart_of_vertex = _split_vertices(mesh, charts.of_triangle)
    frames = tangent_frames(mesh)

    emits = np.array([bool(m.emission_cd_m2.any()) for m in world.materials], dtype=bool)
    # Lamps let their own light out, and what moves on casts no shadow where it rests.
    opaque = np.flatnonzero(~emits[mesh.material[mesh.triangles[:, 0]]] & (mover == 0))
    tracer = RayTracer(mesh.corners_m[opaque])

    light_map, bend_map = _light_texels(world, mesh, frames, charts, tracer)
    on_map = chart_of_vertex >= 0
    coordinates = np.zeros((len(mesh.position_m), 2), np.float32)
    coordinates[on_map] = charts.coordinates(chart_of_vertex[on_map], mesh.position_m[on_map])
    baked = BakedMesh(
        mesh=mesh,
        frames=frames,
        chunks=chunks,
        surface=smooth_surfaces(mesh),
        vertex_light=_light_vertices(world, mesh, frames, ~on_map, tracer),
        map_coordinates=coordinates,
        light_map=light_map,
        bend_map=bend_map,
        opaque=opaque,
    )
    vars(baked)["tracer"] = tracer  # as its property would make it anew
    return baked


def _split_vertices(
    mesh: FlatMesh, chart_of_triangle: NDArray[np.int32]
) -> tuple[FlatMesh, NDArray[np.int32]]:
    """Give every chart vertices of its own, in the order in which triangles use them."""
    charts = int(chart_of_triangle.max(initial=-1)) + 2
    key = mesh.triangles.astype(np.int64) * charts + (chart_of_triangle[:, None] + 1)
    unique, first, inverse = np.unique(key.reshape(-1), return_index=True, return_inverse=True)
    by_use = np.argsort(first, kind="stable")
    rank = np.empty(len(by_use), dtype=np.int32)
    rank[by_use] = np.arange(len(by_use), dtype=np.int32)
    vertex, chart = np.divmod(unique[by_use], charts)
    split = replace(
        mesh,
        position_m=mesh.position_m[vertex],
        normal=mesh.normal[vertex],
        uv=mesh.uv[vertex],
        material=mesh.material[vertex],
        object_id=mesh.object_id[vertex],
        indirect_lux=mesh.indirect_lux[vertex],
        triangles=rank[inverse.reshape(-1, 3)],
    )
    return split, (chart - 1).astype(np.int32)


def _light_vertices(
    world: World, mesh: FlatMesh, frames: NDArray[np.float32], lit: NDArray[np.bool_], tracer: RayTracer
) -> SurfaceLight:
    """Light at the vertices in `lit`; zero at the others."""
    who = np.flatnonzero(lit)
    inward = _towards_triangles(mesh)[who]
    point = (mesh.position_m[who] + 0.02 * inward + LIFT_M * mesh.normal[who]).astype(np.float32)
    light = _reflect(
        world,
        mesh.material[who],
        direct_light(world.lights, point, mesh.normal[who], tracer),
        mesh.indirect_lux[who],
        mesh.normal[who],
        frames[who],
    )

    def spread(values: NDArray[np.float32]) -> NDArray[np.float32]:
        full = np.zeros((len(lit), *values.shape[1:]), np.float32)
        full[who] = values
        return full

    return SurfaceLight(spread(light.luminance_cd_m2), spread(light.unshadowed_share), spread(light.bend))


def _towards_triangles(mesh: FlatMesh) -> NDArray[np.float32]:
    """(V, 3) from each vertex to the mean centre of its triangles [m].

    Vertices where things touch lie exactly on both; a little inwards they see what their own side sees.
    """
    total = mesh.summed_at_vertices(mesh.corners_m.mean(axis=1))
    uses = np.bincount(mesh.triangles.reshape(-1), minlength=len(total))
    return (total / np.maximum(uses, 1)[:, None] - mesh.position_m).astype(np.float32)


def _light_texels(
    world: World, mesh: FlatMesh, frames: NDArray[np.float32], charts: Charts, tracer: RayTracer
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The light map and its bend map."""
    columns, rows = charts.map_size
    image = np.zeros((rows, columns, 6), np.float32)
    chart, column, row = charts.texels()
    normal = charts.normal[chart].astype(np.float32)
    point = (charts.points(chart, column, row) + LIFT_M * normal).astype(np.float32)

    # The surface right below tells whether the texel lies on it, and its indirect light.
    below = RayTracer(mesh.corners_m).first_hits(point, -normal, 2 * LIFT_M)
    other = other_sides(mesh.corners_m)
    behind = below.from_behind & (below.triangle >= 0) & (other[below.triangle] >= 0)
    met = np.where(behind, other[below.triangle], below.triangle)
    on_surface = (met >= 0) & (charts.of_triangle[met] == chart)
    ambient_visibility, buried = near_ambient_visibility(point, normal, on_surface, tracer)
    keep = np.flatnonzero(on_surface & ~buried)
    corners = mesh.triangles[met[keep]]
    weights = np.clip(
        _barycentric(mesh.position_m[corners], point[keep]), 0, 1
    )  # beside one of a side cut otherwise
    weights /= weights.sum(axis=1, keepdims=True)
    around = np.where(_unlit(world)[mesh.material[corners[:, 0]]], 1, ambient_visibility[keep])
    indirect = np.einsum("nc,ncj->nj", weights, mesh.indirect_lux[corners]) * around[:, None]
    light = _reflect(
        world,
        mesh.material[corners[:, 0]],
        direct_light(world.lights, point[keep], normal[keep], tracer),
        indirect.astype(np.float32),
        normal[keep],
        frames[corners[:, 0]],
    )

    x, y = (charts.place[chart] + np.column_stack([column, row]))[keep].T
    image[y, x] = np.column_stack([light.luminance_cd_m2, light.unshadowed_share, light.bend])
    known = np.zeros((rows, columns), dtype=bool)
    known[y, x] = True
    image = grow(image, known, _GROWTH_TEXELS)
    image[0, 0] = 0.0  # padding of the layout: serves the vertices that are lit themselves
    return image[..., :4], image[..., 4:]


def _barycentric(corners_m: NDArray[np.float32], point_m: NDArray[np.float32]) -> NDArray[np.float64]:
    """(N, 3) weights of the corners of (N, 3, 3) triangles at (N, 3) points above them [1]."""
    corners = corners_m.astype(np.float64)
    u, v, p = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], point_m - corners[:, 0]
    normal = np.cross(u, v)
    square = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    second = np.einsum("ij,ij->i", np.cross(p, v), normal) / square
    third = np.einsum("ij,ij->i", np.cross(u, p), normal) / square
    return np.stack([1 - second - third, second, third], axis=1)


def _reflect(
    world: World,
    material: NDArray[np.int32],
    direct: LightAtPoints,
    indirect_lux: NDArray[np.float32],
    normal: NDArray[np.float32],
    frame: NDArray[np.float32],
) -> SurfaceLight:
    """Light that points of materials send back of their direct and indirect light.

    Indirect light is taken to come from the whole hemisphere alike: its mean direction is half the normal.
    For light of mean direction d (length 1 for a small source, 0 for light from everywhere) the irradiance on
    a plane of normal n' is taken as proportional to 1 - |d| + n'.d, exact at both ends.
    """
    base = np.array([m.base_colour * (1 - m.metallic) for m in world.materials], np.float32).reshape(-1, 3)
    takes_direct = ~_unlit(world)[material]
    direct_lux = direct.irradiance_lux * takes_direct[:, None]
    irradiance = direct_lux + indirect_lux
    weight = direct_lux.mean(axis=1, keepdims=True)
    other = indirect_lux.mean(axis=1, keepdims=True)
    towards = (weight * direct.towards + other * 0.5 * normal) / np.maximum(weight + other, 1e-20)
    bright = direct.unshadowed_lux * takes_direct + other[:, 0]
    share = np.where(bright > 0, (weight + other)[:, 0] / np.maximum(bright, 1e-20), 1)
    upright = np.einsum("ij,ij->i", towards, normal)
    level = 1 - np.linalg.norm(towards, axis=1) + upright
    bend = np.einsum("nij,nj->ni", frame, towards) / np.maximum(level, 0.2)[:, None]
    return SurfaceLight(
        luminance_cd_m2=(base[material] * irradiance / np.pi).astype(np.float32),
        unshadowed_share=share.astype(np.float32),
        bend=bend.astype(np.float32),
    )


def _unlit(world: World) -> NDArray[np.bool_]:
    return np.array([material.unlit for material in world.materials], np.bool_)


def grow(image: NDArray[np.float32], known: NDArray[np.bool_], times: int) -> NDArray[np.float32]:
    """Fill unknown texels next to known ones with the mean of those, `times` over.

    >>> grow(np.float32([[[4.0], [0.0], [0.0]]]), np.array([[True, False, False]]), 2).ravel().tolist()
    [4.0, 4.0, 4.0]
    """
    rows, columns = known.shape
    for _ in range(times):
        framed = np.pad(np.where(known[..., None], image, 0), ((1, 1), (1, 1), (0, 0)))
        framed_known = np.pad(known, 1).astype(np.float32)
        total, count = np.zeros_like(image), np.zeros(known.shape, np.float32)
        for dy in range(3):
            for dx in range(3):
                total += framed[dy : dy + rows, dx : dx + columns]
                count += framed_known[dy : dy + rows, dx : dx + columns]
        fill = ~known & (count > 0)
        image = image.copy()
        image[fill] = total[fill] / count[fill][:, None]
        known = known | fill
    return image
