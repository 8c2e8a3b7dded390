"""The world of scene.indoor: one seed one world, light in lux, budgets."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.values import Episode
from tacos_plugins.lighting import LightTransport, photopic
from tacos_worlds.indoor.scene import IndoorScene

SMALL = {"size_m": (10, 5), "frames": 20}


def small(seed: int, lux: float = 20.0, **settings: object) -> Episode:
    scene = IndoorScene(IndoorScene.Config.model_validate({**SMALL, **settings}))
    return scene.episode(rng=np.random.default_rng(seed), illumination_lux=lux)


def test_one_seed_one_world_and_trip() -> None:
    assert fingerprint(small(3)) == fingerprint(small(3))


def test_light_does_not_move_the_furniture() -> None:
    day, night = small(3, lux=20.0), small(3, lux=2.0)
    for a, b in zip(day.world.parts, night.world.parts, strict=True):
        assert np.array_equal(a.vertices_m, b.vertices_m)
    assert day.world.lights[0].flux_lm == pytest.approx(10 * night.world.lights[0].flux_lm, rel=1e-5)


def test_illuminance_agrees_with_an_independent_estimate(episode: Episode) -> None:
    # Other points, other rays and finer places than those the calibration used.
    rng = np.random.default_rng(99)
    points = np.column_stack([rng.uniform(0, 15, (2500, 2)), np.ones(2500)]).astype(np.float32)
    up = np.tile(np.array([0, 0, 1], np.float32), (len(points), 1))
    transport = LightTransport(episode.world, rays=100, merge_m=0.1)
    lux = photopic(transport.direct_lux(points, up) + transport.indirect_lux(points, up))
    assert lux.mean() == pytest.approx(20.0, rel=0.03)


def test_triangle_texture_and_light_budgets(episode: Episode) -> None:
    world = episode.world
    assert world.triangle_count <= 100_000
    textures = {m.texture.tobytes() for m in world.materials if m.texture is not None}
    assert len(textures) <= 45
    assert sum(len(t) == 512 * 512 * 3 for t in textures) <= 8
    assert len(world.lights) <= 12


def test_geometry_is_sound(episode: Episode) -> None:
    for part in episode.world.parts:
        assert np.isfinite(part.vertices_m).all()
        assert part.triangles.min() >= 0
        assert part.triangles.max() < len(part.vertices_m)
        length = np.linalg.norm(part.normals, axis=1)
        assert length == pytest.approx(np.ones(len(length)), abs=1e-4)
        corners = part.vertices_m[part.triangles].astype(float)
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        agrees = np.einsum("ij,ij->i", facing, part.normals[part.triangles].mean(axis=1)) >= -1e-12
        assert agrees.mean() > 0.97


def test_floors_walls_and_ceilings_face_the_room(episode: Episode) -> None:
    # From eye height in each frame, whatever a ray meets first shows its front.
    transport = LightTransport(episode.world)
    rng = np.random.default_rng(1)
    eyes = episode.trajectory.at(episode.time_s[::10])[:, :3, 3].astype(np.float32)
    rays = rng.standard_normal((len(eyes), 60, 3)).astype(np.float32)
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    flat = rays.reshape(-1, 3)
    hits = transport.occlusion.first_hits(np.repeat(eyes, 60, axis=0), flat)
    assert (hits.triangle >= 0).all()
    corners = transport.occlusion.vertices_m[transport.occlusion.triangles[hits.triangle]].astype(float)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    fronts = np.einsum("ij,ij->i", facing, flat) < 0
    assert fronts.mean() > 0.998


def test_reflectance_stays_below_that_of_fresh_snow(episode: Episode) -> None:
    for material in episode.world.materials:
        assert material.base_colour.max() <= 1.0
        assert material.base_colour.min() >= 0.0


def test_visible_emitters_shine_as_their_lights_do(episode: Episode) -> None:
    # Emitted flux, pi * L * area summed over glowing surfaces that lights shine from, against the lights.
    world = episode.world
    flux = sum(light.flux_lm.astype(float) for light in world.lights)
    emitted = np.zeros(3)
    for part in world.parts:
        glow = world.materials[part.material].emission_cd_m2.astype(float)
        if glow.any():
            corners = part.vertices_m[part.triangles].astype(float)
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            area = np.linalg.norm(normal, axis=1) / 2
            panel = part.object_id == 0  # ceiling fittings shine from their undersides
            shining = normal[:, 2] < -0.99 * 2 * area if panel else np.ones(len(area), bool)
            emitted += math.pi * glow * area[shining].sum()
    assert emitted == pytest.approx(flux, rel=0.03)


def test_labels(episode: Episode) -> None:
    world = episode.world
    assert world.objects[0].class_name == "background"
    assert len({thing.name for thing in world.objects}) == len(world.objects)
    labelled = {part.object_id for part in world.parts}
    assert labelled == set(range(len(world.objects)))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size_m": (4, 9)}, "smaller than min_room_m"),
        ({"camera_height_m": (2, 1)}, "must rise"),
        ({"camera_height_m": (1, 2.9)}, "below the ceiling"),
        ({"frames": 0}, "greater than or equal to 1"),
        ({"clutter": 2}, "less than or equal to 1"),
        ({"rooms": 3}, "Extra inputs"),
        ({"size_m": (float("nan"), 9)}, "finite"),
    ],
)
def test_wrong_settings_are_refused_in_a_sentence(settings: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        IndoorScene.Config.model_validate(settings)


def test_darkness_is_refused() -> None:
    with pytest.raises(ValueError, match="above 0, not 0"):
        small(1, lux=0.0)
