"""People on pavements, towns of a limited number of triangles, and streets by night."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tacos_framework.values import Episode
from tacos_plugins.lighting import LightTransport, photopic
from tacos_worlds.street.city import CARRIAGEWAY_M, KERB_M, PAVEMENT_M, draw_town, kerbs
from tacos_worlds.street.crowd import TRIANGLES, populated
from tacos_worlds.street.people import PERSON_TRIANGLES, draw_pedestrians
from tacos_worlds.street.scene import StreetScene
from tacos_worlds.street.streetscape import furnish_town, triangles_of
from tacos_worlds.street.things.fronts import bay_windows, dormers, lit_windows
from tacos_worlds.street.things.vehicles import draw_car

LUX = 10.0


@pytest.fixture(scope="module")
def night() -> Episode:
    scene = StreetScene(
        StreetScene.Config(blocks=1, reach_m=60, frames=3, driving_cars=1, texture_px=64, light="night")
    )
    return scene.episode(rng=np.random.default_rng(3), illumination_lux=LUX)


def test_pedestrians_keep_to_the_pavement_and_out_of_each_others_way() -> None:
    town = draw_town(np.random.default_rng(1), blocks=2, reach_m=100)
    inner = [kerb for kerb in kerbs(town) if kerb.inner]
    found = draw_pedestrians(np.random.default_rng(2), inner, [], 60.0, 40)
    assert len(found) > 30
    clock = np.linspace(0, 60, 200)
    for someone in found:
        low, high = someone.piece.bounds_m
        assert low[2] == pytest.approx(KERB_M, abs=1e-6)
        rest = np.append((low + high)[:2] / 2, [0, 1])
        poses = np.eye(4)[None] if someone.trajectory is None else someone.trajectory.at(clock)
        places = (poses @ rest)[:, :2]
        across = np.minimum(
            np.abs(places[:, :1] - np.array(town.street_x_m)).min(axis=1),
            np.abs(places[:, 1:] - np.array(town.street_y_m)).min(axis=1),
        )
        assert across.min() > CARRIAGEWAY_M / 2 + 0.1
        assert across.max() < CARRIAGEWAY_M / 2 + PAVEMENT_M - 0.2
        if someone.trajectory is not None:
            speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(clock)
            assert speed.max() < 2.2
        assert sum(len(mesh.triangles) for mesh, _ in someone.piece.parts) <= PERSON_TRIANGLES


def test_obstacles_are_walked_around() -> None:
    town = draw_town(np.random.default_rng(1), blocks=1, reach_m=100)
    inner = [kerb for kerb in kerbs(town) if kerb.inner]
    everywhere = [block.grown(5.0) for block in (*town.inner_blocks(), *town.outer_blocks())]
    assert draw_pedestrians(np.random.default_rng(2), inner, everywhere, 60.0, 20) == []


@pytest.mark.parametrize("blocks", [2, 3])
def test_towns_keep_to_their_triangles(blocks: int) -> None:
    town = draw_town(np.random.default_rng(5), blocks=blocks, reach_m=160)
    placed = furnish_town(np.random.default_rng(5), town, greenery=0.3, parked_share=0.9)
    way_m = np.column_stack([np.linspace(*town.street_x_m[:2], 20), np.full(20, town.street_y_m[0])])
    kept, walkers = populated(
        np.random.default_rng(6), town, placed, way_m=way_m, people=24, duration_s=20.0, driving=12
    )
    moving = sum(len(mesh.triangles) for piece, _ in walkers for mesh, _ in piece.parts)
    assert triangles_of(placed) > TRIANGLES * 0.9
    assert triangles_of(kept) + moving + 12 * 340 <= TRIANGLES * 1.02

    def cars(things) -> np.ndarray:
        boxes = [np.array(t.piece.bounds_m) for t in things if t.piece.class_name == "car"]
        return np.array([box.mean(axis=0)[:2] for box in boxes])

    def near(places: np.ndarray) -> int:
        return int((np.linalg.norm(places[:, None] - way_m[None], axis=2).min(axis=1) < 60).sum())

    # Those that are gone are not those that the agent passes.
    assert near(cars(kept)) > 0.6 * near(cars(placed))


def test_lamps_make_the_light_of_a_night(night: Episode) -> None:
    world = night.world
    assert 2 <= len(world.lights) <= 40
    assert all(light.normal is not None and light.normal[2] == pytest.approx(-1) for light in world.lights)
    below = np.array([light.position_m - [0, 0, 6.0] for light in world.lights], np.float32)
    up = np.tile(np.array([0, 0, 1], np.float32), (len(below), 1))
    lux = photopic(LightTransport(world, rays=16, merge_m=2.0, longest_edge_m=9.0).direct_lux(below, up))
    assert np.median(lux) > 1.2 * LUX  # brighter below lamps than between them
    assert world.sky_cd_m2.max() < 1.0


def test_each_glowing_lens_shines_as_its_lamp_does(night: Episode) -> None:
    world = night.world
    glow = [m.emission_cd_m2 for m in world.materials if m.emission_cd_m2.max() > 1000]
    flux = world.lights[0].flux_lm
    area = 4 * float(np.linalg.norm(world.lights[0].half_u_m) * np.linalg.norm(world.lights[0].half_v_m))
    assert any(np.allclose(flux, math.pi * emission * area, rtol=1e-3) for emission in glow)


def test_day_and_night_are_one_town_in_two_lights(night: Episode) -> None:
    scene = StreetScene(StreetScene.Config(blocks=1, reach_m=60, frames=3, driving_cars=1, texture_px=64))
    day = scene.episode(rng=np.random.default_rng(3), illumination_lux=LUX)
    assert np.array_equal(day.trajectory.world_from_agent, night.trajectory.world_from_agent)
    assert day.world.key != night.world.key
    assert len(day.world.lights) == 1
    for mover in (*day.movers, *night.movers):
        assert mover.trajectory.time_s[0] <= 0.0


def test_lit_windows_lie_on_the_wall_within_their_cells() -> None:
    rng = np.random.default_rng(1)
    along = np.array([1.0, 0, 0])
    parts = lit_windows(rng, np.zeros(3), along, 3.0, 4, 3.9, 3, 3.0, share=1.0, panes=False)
    points = np.concatenate([mesh.vertices_m for mesh, _ in parts])
    assert sum(len(mesh.triangles) for mesh, _ in parts) == 2 * 4 * 3
    assert points[:, 1] == pytest.approx(np.full(len(points), -0.02))
    cell = np.column_stack([points[:, 0] / 3 % 1, (points[:, 2] - 3.9) / 3 % 1])
    assert cell.min() > 0.3
    assert cell.max() < 0.76
    assert all(max(finish.emission_cd_m2) > 0 for _, finish in parts)


def test_bay_windows_stand_out_over_the_pavement_and_dormers_on_the_roof() -> None:
    finish = draw_car(np.random.default_rng(0)).parts[0][1]
    bay = np.concatenate([m.vertices_m for m, _ in bay_windows(5, 16.0, 3.9, 4, 3.0, 0, finish)])
    assert bay[:, 1].min() == pytest.approx(-0.73, abs=0.02)
    assert bay[:, 2].min() > 3.5
    assert bay[:, 2].max() < 3.9 + 4 * 3.0
    roof = np.concatenate(
        [m.vertices_m for m, _ in dormers(np.random.default_rng(1), 16.0, 12.0, 15.0, finish)]
    )
    ridge = 15.0 + 0.38 * 12.0
    assert roof[:, 2].min() > 15.0
    assert roof[:, 2].max() < ridge
