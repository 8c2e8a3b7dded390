"""Shading by compiled loops, beside OpenGL's shaders and beside plain numpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import map_coordinates
from small_worlds import box, camera, matte, pose, quad, world

from tacos_framework.values import Light, Material
from tacos_plugins.renderers.moderngl.device import device
from tacos_plugins.renderers.moderngl.rendered_views import EdgeBlending
from tacos_plugins.renderers.software import pixel_batch as row
from tacos_plugins.renderers.software.light_loops import between_two, mirror_rays, reflect
from tacos_plugins.renderers.software.lookup_loops import colours, light_of_maps, look_into_probes, tilts
from tacos_plugins.renderers.software.seen_triangles import planes, runs_by_kind
from tacos_plugins.renderers.software.shading_tables import TexelStack

NEAR_M = 0.05


def both_ways(place, at, seen_by, moved=None):
    """(2, H, W, 3) the same picture by loops and by OpenGL."""
    painter = device().painter(place, 0.05).with_moved(moved or {})
    return [
        EdgeBlending(device().targets, seen_by, NEAR_M, by_loops=by_loops).take(painter, at).luminance_cd_m2
        for by_loops in (True, False)
    ]


def differing(by_loops, by_gl, share_of_white=0.02):
    """Share of the pixels that differ by more than that."""
    white = np.percentile(by_gl, 99)
    return float((np.abs(by_loops - by_gl).max(axis=-1) > share_of_white * white).mean())


def materials():
    """One of each kind: with and without texture, bumps and gloss; metal; something that glows."""
    generator = np.random.default_rng(3)
    texture = np.kron(generator.integers(40, 255, (16, 16, 3)), np.ones((8, 8, 1))).astype(np.uint8)
    bumps = np.full((64, 64, 3), 128, np.uint8)
    bumps[::8, :, 0], bumps[:, ::8, 1] = 190, 70
    looks = [{}, {"texture": texture}, {"normal_map": bumps}, {"texture": texture, "normal_map": bumps}]
    finishes = [{"roughness": 1.0}, {"roughness": 0.3}, {"roughness": 0.2, "metallic": 1.0}]
    kinds = [
        Material("m", np.array([0.8, 0.6, 0.4]), texture_size_m=0.5, **look, **finish)
        for look in looks
        for finish in finishes
    ]
    return [*kinds, matte(0.5, emission_cd_m2=np.array([3.0, 20.0, 5.0]))]


def display():
    """Large panels, which light maps light, with a box on each, lit per vertex, in all materials."""
    kinds = materials()
    parts = []
    for number in range(len(kinds)):
        y, z = 1.6 * (number % 4 - 1.5), 1.6 * (number // 4 - 1.5)
        parts.append(quad((5.0, y, z), (0, 0, 0.8), (0, 0.8, 0), number))
        parts += box((4.6, y - 0.05, z - 0.05), (4.8, y + 0.15, z + 0.15), number, 1)
    lamps = [Light(np.array([1.0, 1.0, 2.0]), np.full(3, 3000.0), radius_m=0.1)]
    return world(parts, kinds, lamps, ambient_cd_m2=2.0)


@pytest.mark.gl
@pytest.mark.parametrize("yaw", [-0.3, 0.0, 0.4])
def test_all_kinds_of_surfaces_look_as_opengl_draws_them(yaw):
    place = display()
    seen_by = camera(320, 240, focal_px=250.0)
    at = pose((0.0, 0.0, 0.0), (1.0, yaw, 0.1)) @ seen_by.agent_from_camera
    by_loops, by_gl = both_ways(place, at, seen_by)
    drawn = device().painter(place, 0.05).world
    assert (
        len(drawn.by_loops.tables.kinds) >= 14
    )  # all that there are, or the test would tell less than it says
    assert differing(by_loops, by_gl) < 0.01
    np.testing.assert_allclose(by_loops.mean(axis=(0, 1)), by_gl.mean(axis=(0, 1)), rtol=3e-3)


triples = st.lists(st.floats(-1, 1), min_size=3, max_size=3)


@settings(max_examples=200, deadline=None)
@given(
    corners=arrays(np.float32, (3, 3), elements=st.floats(-3, 3, width=32)),
    values=arrays(np.float32, (3, 2), elements=st.floats(-2, 2, width=32)),
    inside=arrays(np.float64, 3, elements=st.floats(0.05, 1)),
)
def test_what_triangles_say_is_that_of_the_place_a_pixel_sees(corners, values, inside):
    """Also where corners lie behind the camera, since the place seen does not."""
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    share = inside / inside.sum()
    place = share @ corners.astype(np.float64)
    if area < 0.3 or place[2] < 0.1:
        return
    pixel_from_world = np.array([[40.0, 0, 30, 0], [0, 40, 20, 0], [0, 0, 1, 0]])
    if abs(np.linalg.det(pixel_from_world[:, :3] @ corners.T.astype(np.float64))) < 50:
        return  # seen from the side
    one = np.array([1], np.int32)
    mesh = (np.array([[0, 1, 2]], np.int32), corners, values, np.zeros(2, np.int32))
    filled = np.empty((1, 3, 5))
    planes(one, *mesh, pixel_from_world[None], filled)
    found = filled[0]
    x, y, depth = pixel_from_world[:, :3] @ place
    over_depth = found[:, :3] @ [x / depth, y / depth, 1]
    np.testing.assert_allclose(found[:2, 3:], np.stack([values.min(axis=0), values.max(axis=0)], axis=1))
    np.testing.assert_allclose(over_depth[-1], 1 / depth, rtol=1e-3)
    np.testing.assert_allclose(over_depth[:2] * depth, share @ values, rtol=1e-3, atol=1e-3)


@given(arrays(np.int32, (6, 9), elements=st.integers(0, 4)))
def test_runs_hold_every_pixel_that_sees_something_once_with_those_of_its_kind(triangle):
    kind_of_triangle = np.array([0, 1, 0, 1, 2], np.int32)
    runs, first, seen = runs_by_kind(triangle, kind_of_triangle, 3)
    filled = np.zeros_like(triangle)
    for kind in range(3):
        for number, slot, y, x, length in runs[first[kind] : first[kind + 1]]:
            assert kind_of_triangle[number] == kind
            assert seen[slot] == number
            assert not filled[y, x : x + length].any()
            filled[y, x : x + length] = number
    np.testing.assert_array_equal(filled, triangle)
    assert sorted(seen) == sorted(set(triangle.reshape(-1)) - {0})


def batch(**rows):
    """A batch of the pixels that some rows have numbers for."""
    made = row.PixelBatch()
    for name, values in rows.items():
        begin = getattr(row, name.upper())
        target = made.integers if np.asarray(values).dtype.kind == "i" else made.floats
        target[begin : begin + len(values)] = values
    return made


def row_of(values, begin, count):
    return values[begin : begin + count].astype(np.float64)


@settings(max_examples=50, deadline=None)
@given(at=arrays(np.float32, (2, 20), elements=st.floats(-3, 3, width=32)), layer=st.integers(0, 2))
def test_textures_repeat_and_are_filtered_between_texels(at, layer):
    images = np.random.default_rng(0).integers(0, 256, (3, 8, 8, 4)).astype(np.uint8)
    stack = TexelStack.of([images])
    near = np.full(20, 1e-3, np.float32)
    pixels = batch(u=at[0], v=at[1], u_x=near, v_y=near, colour_layer=np.full(20, layer, np.int32))
    colours(stack.texels, stack.offsets, stack.edge, pixels.floats, pixels.integers, 20)
    for channel, begin in enumerate((row.TEXEL_RED, row.TEXEL_GREEN, row.TEXEL_BLUE)):
        expected = map_coordinates(
            images[layer, :, :, channel].astype(float),
            [at[1] * 8 - 0.5, at[0] * 8 - 0.5],
            order=1,
            mode="grid-wrap",
        )
        np.testing.assert_allclose(255 * row_of(pixels.floats, begin, 20), expected, atol=2.5)


@pytest.mark.parametrize(("texels", "level"), [(0.9, 0), (1.3, 0), (1.6, 1), (2.7, 1), (2.95, 2), (100.0, 3)])
def test_a_footprint_of_so_many_texels_is_looked_up_on_this_level(texels, level):
    stack = TexelStack.of([np.full((1, 8 >> n, 8 >> n, 4), n, np.uint8) for n in range(4)])
    wide = np.array([texels / 8], np.float32)
    pixels = batch(u_x=wide, v_y=wide, normal_layer=np.zeros(1, np.int32))
    tilts(stack.texels, stack.offsets, stack.edge, pixels.floats, pixels.integers, 1)
    assert pixels.integers[row.LEVEL] == level


def test_a_texture_seen_at_a_grazing_angle_is_the_mean_along_its_footprint():
    stripes = np.zeros((1, 16, 16, 4), np.uint8)
    stripes[:, :, ::2] = 200  # stripes across u
    stack = TexelStack.of([stripes, np.full((1, 8, 8, 4), 100, np.uint8)])
    long, short = np.array([4 / 16], np.float32), np.array([1 / 16], np.float32)
    pixels = batch(u=np.array([0.5], np.float32), u_x=long, v_y=short)
    colours(stack.texels, stack.offsets, stack.edge, pixels.floats, pixels.integers, 1)
    assert pixels.integers[row.TAPS] == 4
    assert pixels.integers[row.LEVEL] == 0
    np.testing.assert_allclose(255 * pixels.floats[row.TEXEL_RED], 100, atol=2)


@settings(max_examples=50, deadline=None)
@given(at=arrays(np.float32, (2, 10), elements=st.floats(0, 1, width=32)))
def test_light_maps_are_filtered_and_end_at_their_edges(at):
    generator = np.random.default_rng(1)
    light, bend = generator.random((5, 7, 4), np.float32), generator.random((5, 7, 2), np.float32)
    pixels = batch(map_u=at[0], map_v=at[1])
    light_of_maps(light, bend, pixels.floats, 10)
    for table, begins in (
        (light, (row.RED, row.GREEN, row.BLUE, row.SHARE)),
        (bend, (row.BEND_U, row.BEND_V)),
    ):
        for channel, begin in enumerate(begins):
            where = [at[1] * 5 - 0.5, at[0] * 7 - 0.5]
            expected = map_coordinates(table[..., channel].astype(float), where, order=1, mode="nearest")
            np.testing.assert_allclose(row_of(pixels.floats, begin, 10), expected, atol=1e-5)


@settings(max_examples=50, deadline=None)
@given(
    roughness=st.floats(0.05, 1), metallic=st.sampled_from([0.0, 0.5, 1.0]), facing=st.floats(0.02, 1),
    share=st.floats(0, 1), texel=st.floats(0, 1),
)  # fmt: skip
def test_mirrored_light_is_that_of_the_formula(roughness, metallic, facing, share, texel):
    base, emission = np.array([0.9, 0.5, 0.1]), np.array([0.0, 1.0, 2.0])
    light, around = np.array([4.0, 5.0, 6.0]), np.array([9.0, 8.0, 7.0])
    table = np.array([[*base, roughness, metallic, 0, *emission]], np.float32)
    colour = ("red", "green", "blue")
    numbers = {"facing": facing, "share": share, **{f"texel_{name}": texel for name in colour}}
    numbers |= dict(zip(colour, light, strict=True))
    numbers |= {f"around_{name}": value for name, value in zip(colour, around, strict=True)}
    one = {name: np.full(1, value, np.float32) for name, value in numbers.items()}
    pixels = batch(**one)
    reflect(table, pixels.floats, pixels.integers, 1)
    r = roughness * np.array([-1, -0.0275, -0.572, 0.022]) + [1, 0.0425, 1.04, -0.04]
    x = min(r[0] ** 2, 2 ** (-9.28 * facing)) * r[0] + r[1]
    sheen = np.clip((0.8 - roughness) / 0.4, 0, 1)
    f0 = (1 - metallic) * 0.04 * sheen + metallic * base * texel**2
    returned = f0 * (-1.04 * x + r[2]) + max(sheen, metallic) * (1.04 * x + r[3])
    expected = light * (1 - returned) + returned * around * (0.25 + 0.75 * share) + emission
    found = [pixels.floats[begin] for begin in (row.RED, row.GREEN, row.BLUE)]
    np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-5)


wild = arrays(
    np.float32,
    row.ATTRIBUTES + 10,
    elements=st.sampled_from([0.0, -1.0, 0.5, 1e-30, 3e38, -3e38, np.inf, np.nan]),
)


wild_numbers = st.sampled_from([0.0, -1.0, 0.5, 1e-30, 3e38, -3e38, np.inf, np.nan])


@settings(max_examples=200, deadline=None)
@given(arrays(np.float32, row.ATTRIBUTES + 10, elements=wild_numbers))
def test_numbers_that_are_none_fetch_nothing_from_beyond_a_table(numbers):
    """A pixel may turn out black; a place outside of a table would end the process."""
    pixels = row.PixelBatch()
    pixels.floats.reshape(-1, row.CAPACITY)[: len(numbers), :16] = numbers[:, None]
    floats, integers = pixels.floats, pixels.integers
    stack = TexelStack.of([np.full((1, 4 >> n, 4 >> n, 4), 9, np.uint8) for n in range(3)])
    maps = np.ones((3, 2, 4), np.float32), np.ones((3, 2, 2), np.float32)
    materials, boxes = np.full((1, 9), 0.5, np.float32), np.array([[[0] * 3, [0] * 3, [0] * 3]], np.float32)
    materials[0, 5] = 0
    light_of_maps(*maps, floats, 16)
    tilts(stack.texels, stack.offsets, stack.edge, floats, integers, 16)
    colours(stack.texels, stack.offsets, stack.edge, floats, integers, 16)
    mirror_rays(np.zeros((2, 2), np.float32), (0.0, 0.0, 1.0), materials, floats, integers, 16)
    look_into_probes(np.ones((1, 2, 2, 3), np.float32), boxes, 1, 0.5, floats, integers, 16)
    for begin in (row.RED, row.SHARE, row.BEND_U, row.TEXEL_RED, row.TILT_U, row.AROUND_BLUE, row.FACING):
        assert np.isfinite(floats[begin : begin + 16]).all()
    assert floats[row.RED] == 1
    np.testing.assert_allclose(floats[row.TEXEL_RED : row.TEXEL_RED + 16], 9 / 255, rtol=1e-5)


def test_only_pixels_between_rooms_look_into_a_second_probe():
    weight = np.array([0, 0.3, 0, 0.2], np.float32)
    pixels = batch(
        second_weight=weight,
        place_x=np.arange(4, dtype=np.float32),
        second_probe=np.arange(4, dtype=np.int32),
    )
    into = row.PixelBatch()
    assert between_two(pixels.floats, pixels.integers, 4, into.floats, into.integers) == 2
    np.testing.assert_array_equal(into.floats[row.PLACE_X : row.PLACE_X + 2], [1, 3])
    np.testing.assert_array_equal(into.floats[row.WEIGHT : row.WEIGHT + 2], weight[[1, 3]])
    np.testing.assert_array_equal(into.integers[row.PROBE : row.PROBE + 2], [1, 3])
