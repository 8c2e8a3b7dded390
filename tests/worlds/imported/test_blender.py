"""A house exported from Blender, and its pictures taken in Blender; where bpy is installed."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from small_worlds import box, camera, matte, pose, quad, rig, standing, world

from tacos_framework.errors import UserError
from tacos_framework.values import Exposure, Light
from tacos_plugins.renderers.blender.renderer import BlenderRenderer
from tacos_worlds.imported.scene import ImportedScene

has_blender = importlib.util.find_spec("bpy") is not None
needs_blender = pytest.mark.skipif(not has_blender, reason="takes bpy (the extra blender)")
SCRIPT = Path(__file__).with_name("blender_house.py")


@pytest.mark.skipif(has_blender, reason="bpy is installed")
def test_without_blender_it_says_what_to_install() -> None:
    episode = standing(world(box((-2, -2, -2), (2, 2, 2))))
    with pytest.raises(UserError, match=r"tacos-framework\[blender\]"):
        BlenderRenderer(BlenderRenderer.Config()).capture(episode, rig=rig(camera()), exposure=Exposure())


@needs_blender
@pytest.mark.slow
def test_a_house_exported_from_blender_is_walked_lit_and_labelled(tmp_path: Path) -> None:
    file = tmp_path / "house.glb"
    subprocess.run([sys.executable, str(SCRIPT), str(file)], check=True, capture_output=True)
    config = ImportedScene.Config(
        file=str(file), sampling="approaches", before_step_s=(3.2, 3.0, 1.2, 1.0), frames=8, size_m=(10, 6)
    )
    scene = ImportedScene(config)
    episode = scene.episode(rng=np.random.default_rng(7), illumination_lux=20.0)
    classes = [thing.class_name for thing in episode.world.objects]
    assert classes.count("threshold") == 3  # two by name, one by a custom property
    assert {"sofa", "bed", "table", "toy"} < set(classes)
    assert len(episode.world.lights) == 5  # four panels that glow, one point light
    assert len(episode) == 8
    assert len(episode.crossings) == 2
    assert scene.place.floor.area_m2 > 30


@needs_blender
@pytest.mark.slow
def test_radiance_is_that_of_the_inverse_square_law() -> None:
    # A white floor below a small square lamp in the dark: E = I cos^4 / h^2, L = r E / pi.
    lamp = Light(
        np.float32([2, 0, 2]), np.float32([100, 100, 100]), np.float32([0, 0, -1]),
        np.float32([0.05, 0, 0]), np.float32([0, 0.05, 0]),
    )  # fmt: skip
    floor = quad((2, 0, -1), (3, 0, 0), (0, 3, 0))
    lit = world([floor], materials=[matte(0.6)], lights=[lamp])
    renderer = BlenderRenderer(BlenderRenderer.Config(samples=64, max_depth=2))
    down = camera(33, 33, 60.0)
    view = renderer.capture(
        standing(lit, pose((0, 0, 0), (2, 0, -0.9))), rig=rig(down), exposure=Exposure()
    ).views[0]
    seen_from = view.world_from_camera[0]
    rays = np.stack(np.meshgrid(np.arange(33), np.arange(33)), -1) - np.array(down.centre_px)
    rays = np.dstack([rays / down.focal_length_px, np.ones((33, 33))]) @ seen_from[:3, :3].T
    hit = np.isfinite(view.depth_m[0])
    points = seen_from[:3, 3] + rays * np.where(hit, view.depth_m[0], 0)[..., None]
    offset = points[hit] - lamp.position_m
    squared = (offset**2).sum(axis=1)
    illuminance = 100 / np.pi * (-offset[:, 2]) ** 2 / squared**2
    assert hit.sum() > 100
    assert np.median(view.luminance_cd_m2[0][hit][:, 1] / (0.6 * illuminance / np.pi)) == pytest.approx(
        1, abs=0.02
    )
