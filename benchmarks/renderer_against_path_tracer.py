"""How far `renderer.moderngl` is from path-traced light on furnished indoor worlds, and where.

python benchmarks/renderer_against_path_tracer.py --backend llvm --figure figure.jpg

Needs the extra `mitsuba`. Errors are of the mean of the colour channels, relative to the path tracer, pixel
by pixel; pixels at the edges of objects are left out, where half a pixel of another surface decides. On two
cores this takes several minutes with LLVM, and an hour without.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from renderers.tour import benchmark_camera, parse_size

from tacos_framework import Episode, Exposure, Rig, View, World
from tacos_framework.camera import pixel_rays
from tacos_plugins.lighting.direct import direct_irradiance
from tacos_plugins.lighting.occlusion import Occlusion
from tacos_plugins.renderers.mitsuba.renderer import MitsubaRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_worlds.indoor.scene import IndoorScene

MATTE_ROUGHNESS = 0.8
NEAR_LAMP_M = 1.0


@dataclass(frozen=True, eq=False)
class Pixels:
    """What the pixels of one view show.

    Parameters
    ----------
    groups
        For each name of a group, (H, W) bool: the pixels in it.
    compared
        (H, W) bool: pixels that show one surface only.
    """

    groups: dict[str, NDArray[np.bool_]]
    compared: NDArray[np.bool_]


def main() -> None:
    """Print the errors, and draw the figure."""
    arguments = parse_arguments()
    traced = MitsubaRenderer(MitsubaRenderer.Config(samples=arguments.samples, backend=arguments.backend))
    again = MitsubaRenderer(
        MitsubaRenderer.Config(samples=arguments.samples, backend=arguments.backend, seed=1)
    )
    rasterised = ModernglRenderer(ModernglRenderer.Config())
    rig = Rig((benchmark_camera(*arguments.size, pitch_deg=-8.0),))
    errors: dict[str, list[NDArray[np.float64]]] = {}
    noise: list[NDArray[np.float64]] = []
    pictures = []
    for world_seed in range(1, arguments.worlds + 1):
        for episode in views_of(world_seed, arguments.views):
            ours = rasterised.capture(episode, rig=rig, exposure=Exposure()).views[0]
            reference = traced.capture(episode, rig=rig, exposure=Exposure()).views[0]
            pixels = classify(episode.world, reference)
            error = relative_error(ours, reference)
            for name, here in pixels.groups.items():
                errors.setdefault(name, []).append(error[here & pixels.compared])
            if not noise:
                other = again.capture(episode, rig=rig, exposure=Exposure()).views[0]
                matte = pixels.groups["diffuse"] & pixels.compared
                noise.append(relative_error(other, reference)[matte] / np.sqrt(2))
            pictures.append((luminance(ours), luminance(reference), error))
            print(
                f"world {world_seed}, frame {episode.first_frame}: {summary(errors['diffuse'][-1])}",
                flush=True,
            )
    print(f"\n{'pixels':22} {'share':>6} {'median |error|':>15} {'median error':>13} {'90 % below':>11}")
    total = sum(len(part) for part in errors["all"])
    for name, parts in errors.items():
        together = np.concatenate(parts)
        if len(together):
            size, middle = np.abs(together), np.median(together)
            print(
                f"{name:22} {len(together) / total:6.1%} {np.median(size):15.1%} {middle:+13.1%} "
                f"{np.quantile(size, 0.9):11.1%}"
            )
    print(f"noise of the reference (median): {np.median(np.abs(noise[0])):.1%}")
    if arguments.figure:
        draw(pictures, arguments.figure)


def summary(error: NDArray[np.float64]) -> str:
    """Median size and median of an error, for a line of progress."""
    return f"diffuse {np.median(np.abs(error)):.1%} (signed {np.median(error):+.1%})"


def views_of(world_seed: int, count: int) -> Iterator[Episode]:
    """Frames spread over the trip through a small floor."""
    scene = IndoorScene(IndoorScene.Config(size_m=(11.0, 9.0), frames=60))
    episode = scene.episode(rng=np.random.default_rng(world_seed), illumination_lux=100.0)
    for frame in np.linspace(0, len(episode) - 1, count + 2).astype(int)[1:-1]:
        yield episode[frame : frame + 1]


def luminance(view: View) -> NDArray[np.float64]:
    """(H, W) mean of the channels [cd/m2]."""
    return view.luminance_cd_m2[0].mean(axis=-1, dtype=np.float64)


def relative_error(ours: View, reference: View) -> NDArray[np.float64]:
    """(H, W) signed error of `ours`, relative to the reference [1]."""
    truth = luminance(reference)
    return luminance(ours) / np.maximum(truth, 1e-3 * np.median(truth)) - 1


def classify(world: World, view: View) -> Pixels:
    """Sort the pixels of a view by material, surface and light."""
    occlusion = Occlusion(world)
    pose, shape = view.world_from_camera[0], view.depth_m.shape[1:]
    rays = (pixel_rays(view.camera).reshape(-1, 3) @ pose[:3, :3].T).astype(np.float32)
    hits = occlusion.first_hits(np.tile(pose[:3, 3].astype(np.float32), (len(rays), 1)), rays)
    counts = [len(part.triangles) for part in world.parts]
    part = np.repeat(np.arange(len(world.parts)), counts)[hits.triangle]
    corners = occlusion.triangles[hits.triangle]
    normals = np.concatenate([p.normals for p in world.parts])
    normal = np.einsum("nc,ncj->nj", hits.barycentric, normals[corners])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    normal *= np.where(np.einsum("nj,nj->n", normal, rays) > 0, -1, 1)[:, None]
    point = (pose[:3, 3] + hits.distance_m[:, None] * rays).astype(np.float32)

    material = np.array([p.material for p in world.parts])[part]
    emits = np.array([m.emission_cd_m2.any() for m in world.materials])[material]
    matte = np.array([m.roughness >= MATTE_ROUGHNESS and m.metallic == 0 for m in world.materials])[material]
    thing = np.array([p.object_id for p in world.parts])[part] > 0
    share = share_of_strongest_light(world, occlusion, point, normal.astype(np.float32))
    lamps = np.array([light.position_m for light in world.lights]).reshape(-1, 3)
    lamp_m = np.linalg.norm(point[:, None] - lamps, axis=2).min(axis=1)
    structure = ~thing
    high = float(occlusion.vertices_m[:, 2].max())
    diffuse = matte & ~emits
    groups = {
        "all": ~emits,
        "diffuse": diffuse,
        "glossy or metal": ~matte & ~emits,
        "diffuse floor": diffuse & structure & (normal[:, 2] > 0.9) & (point[:, 2] < 0.1),
        "diffuse walls": diffuse & structure & (np.abs(normal[:, 2]) < 0.1),
        "diffuse ceiling": diffuse & structure & (normal[:, 2] < -0.9) & (point[:, 2] > high - 0.4),
        "diffuse furniture": diffuse & thing,
        "diffuse, lit": diffuse & (share > 0.95),
        "diffuse, penumbra": diffuse & (share > 0.05) & (share <= 0.95),
        "diffuse, shadow": diffuse & (share <= 0.05),
        "diffuse, lamp < 1 m": diffuse & (lamp_m < NEAR_LAMP_M),
    }
    key = (part * 64 + np.rint((normal[:, 2] + 1) * 8).astype(int)).reshape(shape)
    compared = np.ones(shape, dtype=bool)
    for axis in (0, 1):
        for step in (1, -1):
            compared &= np.roll(key, step, axis) == key
    compared[[0, -1]] = compared[:, [0, -1]] = False
    compared &= (hits.triangle >= 0).reshape(shape)
    return Pixels({name: here.reshape(shape) for name, here in groups.items()}, compared)


def share_of_strongest_light(
    world: World, occlusion: Occlusion, point_m: NDArray[np.float32], normal: NDArray[np.float32]
) -> NDArray[np.float64]:
    """(N,) how much of the light that would give a point most is seen from there, 0 for no light [1]."""
    empty = Occlusion(replace(world, parts=(), indirect_lux=None))
    alone = np.stack(
        [direct_irradiance(empty, [light], point_m, normal).mean(axis=1) for light in world.lights], axis=1
    )
    strongest = alone.argmax(axis=1)
    share = np.zeros(len(point_m))
    for index, light in enumerate(world.lights):
        who = np.flatnonzero((strongest == index) & (alone[:, index] > 0))
        seen = direct_irradiance(occlusion, [light], point_m[who], normal[who], samples_per_edge=6)
        full = direct_irradiance(empty, [light], point_m[who], normal[who], samples_per_edge=6)
        share[who] = seen.mean(axis=1) / np.maximum(full.mean(axis=1), 1e-12)
    return share


def draw(
    pictures: Sequence[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]], path: str
) -> None:
    """Draw each view rasterised, path-traced, and the signed relative error."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, rows = plt.subplots(
        len(pictures), 3, figsize=(10.5, 2.55 * len(pictures)), squeeze=False, layout="constrained"
    )
    for row, (ours, reference, error) in zip(rows, pictures, strict=True):
        white = np.quantile(reference, 0.98)
        for axes, picture in zip(row, (ours, reference), strict=False):
            axes.imshow(np.clip(picture / white, 0, 1) ** (1 / 2.2), cmap="gray", vmin=0, vmax=1)
        shown = row[2].imshow(100 * error, cmap="RdBu_r", vmin=-50, vmax=50)
        figure.colorbar(shown, ax=row[2], label="error [%]")
        for axes in row:
            axes.set_xticks([])
            axes.set_yticks([])
    for axes, title in zip(rows[0], ("renderer.moderngl", "renderer.mitsuba", "relative error"), strict=True):
        axes.set_title(title)
    figure.savefig(path, dpi=90, pil_kwargs={"quality": 85} if path.endswith(".jpg") else None)
    plt.close(figure)


def parse_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--worlds", type=int, default=2, help="number of worlds")
    parser.add_argument("--views", type=int, default=2, help="views of each world")
    parser.add_argument("--samples", type=int, default=1024, help="paths per pixel of the path tracer")
    parser.add_argument("--size", type=parse_size, default=(112, 84), help="image size, WIDTHxHEIGHT [px]")
    parser.add_argument("--backend", default="scalar", help="backend of renderer.mitsuba")
    parser.add_argument("--figure", default="", help="file to draw the views into, .jpg or .png")
    return parser.parse_args()


if __name__ == "__main__":
    main()
