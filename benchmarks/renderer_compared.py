"""Frames per second of `renderer.moderngl` and of pyrender on the same meshes, side by side in one run.

pip install tacos-framework[bench]
OMP_NUM_THREADS=1 python benchmarks/renderer_compared.py --frames 40

Both draw the same poses of the same furnished world through EGL and read the frames back. pyrender gives
colour (8 bits, four samples a pixel) and depth; ids take it a second pass, which is timed too. Its light is
that of its own shader, four point lights without shadows; ours is baked, with shadows and indirect light.
The two take turns frame by frame, so that what else the machine does weighs on both alike.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray
from renderer_speed import parse_size

from tacos_framework.camera.geometry import agent_from_camera, world_from_camera
from tacos_framework.values import Camera, Exposure, Rig, World
from tacos_plugins.renderers.moderngl.context import describe_gl, gl_context
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer
from tacos_worlds.indoor.scene import IndoorScene

os.environ["PYOPENGL_PLATFORM"] = "egl"
if not hasattr(np, "infty"):
    vars(np)["infty"] = np.inf  # pyrender 0.1.45 is from before NumPy 2
warnings.simplefilter("ignore")

_MOST_LIGHTS = 4


def main() -> None:
    """Print frames per second of both, and their ratio."""
    arguments = parse_arguments()
    scene = IndoorScene(IndoorScene.Config())
    episode = scene.episode(rng=np.random.default_rng(arguments.seed), illumination_lux=20.0)
    width_px, height_px = arguments.size
    camera = Camera(
        name="benchmark",
        width_px=width_px,
        height_px=height_px,
        pixel_um=3840.0 / width_px,
        focal_length_mm=2.4,
        agent_from_camera=agent_from_camera((0.0, 0.0, 0.0), pitch_deg=-10.0),
    )
    rig, exposure = Rig((camera,)), Exposure()
    ours = ModernglRenderer(ModernglRenderer.Config())
    theirs = Pyrender(episode.world, camera)
    frames = np.linspace(0, len(episode) - 1, arguments.frames).astype(int)
    poses = world_from_camera(episode.trajectory.at(episode.time_s[frames]), camera.agent_from_camera)

    def capture(i: int) -> Any:
        with gl_context():  # pyrender leaves its own current
            return ours.capture(episode[frames[i] : frames[i] + 1], rig=rig, exposure=exposure)

    ways = {
        "renderer.moderngl: colour, depth, ids": capture,
        "pyrender: colour, depth": lambda i: theirs.colour(poses[i]),
        "pyrender: colour, depth, ids": lambda i: (theirs.colour(poses[i]), theirs.ids(poses[i])),
    }
    for take in ways.values():  # lights the world, uploads it, compiles shaders
        for i in range(0, len(frames), 5):
            take(i)
    seconds = dict.fromkeys(ways, 0.0)
    for i in range(len(frames)):
        for name, take in ways.items():
            start = time.perf_counter()
            take(i)
            seconds[name] += time.perf_counter() - start

    print(f"{describe_gl()}; {episode.world.triangle_count} triangles; {width_px} x {height_px}")
    first = next(iter(seconds.values()))
    for name, total in seconds.items():
        print(f"{name:40s} {len(frames) / total:6.1f} frames/s  {total / first:5.2f} times the time of ours")


class Pyrender:
    """The same world and camera for pyrender."""

    def __init__(self, world: World, camera: Camera):
        import pyrender

        self._flags = pyrender.RenderFlags
        self._scene = pyrender.Scene(ambient_light=[0.3, 0.3, 0.3])
        self._colour_of_node: dict[Any, tuple[int, int, int]] = {}
        materials = [_material(pyrender, material) for material in world.materials]
        for part in world.parts:
            primitive = pyrender.Primitive(
                positions=part.vertices_m,
                normals=part.normals,
                texcoord_0=part.uv_m / world.materials[part.material].texture_size_m,
                indices=part.triangles,
                material=materials[part.material],
            )
            node = self._scene.add(pyrender.Mesh([primitive]))
            self._colour_of_node[node] = (part.object_id & 255, part.object_id >> 8, 0)
        for light in sorted(world.lights, key=lambda each: -float(each.flux_lm.mean()))[:_MOST_LIGHTS]:
            pose = np.eye(4)
            pose[:3, 3] = light.position_m
            self._scene.add(pyrender.PointLight(intensity=float(light.flux_lm.mean()) / 100), pose=pose)
        focal, (cx, cy) = camera.focal_length_px, camera.centre_px
        intrinsics = pyrender.IntrinsicsCamera(focal, focal, cx + 0.5, cy + 0.5, znear=0.05, zfar=30.0)
        self._camera = self._scene.add(intrinsics)
        self._renderer = pyrender.OffscreenRenderer(camera.width_px, camera.height_px)

    def colour(self, pose: NDArray[np.float64]) -> Any:
        """Colour and depth from a camera pose."""
        self._place(pose)
        return self._renderer.render(self._scene)

    def ids(self, pose: NDArray[np.float64]) -> Any:
        """Object ids as colours, and depth."""
        self._place(pose)
        return self._renderer.render(self._scene, self._flags.SEG, self._colour_of_node)

    def _place(self, pose: NDArray[np.float64]) -> None:
        self._scene.set_pose(self._camera, pose @ np.diag([1.0, -1.0, -1.0, 1.0]))  # OpenGL looks along -z


def _material(pyrender: Any, material: Any) -> Any:
    texture = None
    if material.texture is not None:
        texture = pyrender.Texture(source=material.texture, source_channels="RGB")
    return pyrender.MetallicRoughnessMaterial(
        baseColorFactor=[*map(float, material.base_colour), 1.0],
        baseColorTexture=texture,
        roughnessFactor=material.roughness,
        metallicFactor=material.metallic,
        doubleSided=True,
    )


def parse_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--size", type=parse_size, default=(640, 480), help="image size, WIDTHxHEIGHT [px]")
    parser.add_argument("--frames", type=int, default=40, help="number of frames")
    parser.add_argument("--seed", type=int, default=1, help="seed of the world")
    return parser.parse_args()


if __name__ == "__main__":
    main()
