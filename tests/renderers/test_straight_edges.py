"""A straight edge of the world, seen through a lens, lies where the closed form has it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray
from small_worlds import camera, matte, pose, quad, rig, standing, world

from tacos_framework.camera import pixel_rays, world_from_camera
from tacos_framework.formation import captured
from tacos_framework.values import Camera, Exposure, Lens
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

MODERNGL = ModernglRenderer(ModernglRenderer.Config(light_texel_m=0.2))
AGENT = pose((0.0, 0.0, 0.0))
PLATE_M, EDGE_M = 2.0, np.array([0.37, 0.18])
"""How far ahead the plate is [m], and its edge: y = a + b z."""
FINER = 12
ROWS = 16
"""Rows over which the place of the edge is averaged."""
EQUIDISTANT = Lens("equidistant", half_field_deg=95.0)
SEEN_BY = {
    "rectilinear": camera(212, 200, 64.0),
    "equidistant 190": replace(camera(212, 200, 64.0), lens=EQUIDISTANT),
    "T265-like": replace(
        camera(212, 200, 70.5), lens=Lens("kannala-brandt", (-0.003, 0.054, -0.052, 0.011), 81.5)
    ),
}


def covered(seen_by: Camera) -> NDArray[np.float64]:
    """(H, W) share of each pixel that the plate covers, of FINER x FINER rays a pixel."""
    finer = replace(
        seen_by,
        width_px=seen_by.width_px * FINER,
        height_px=seen_by.height_px * FINER,
        pixel_um=seen_by.pixel_um / FINER,
    )
    to_world = world_from_camera(AGENT, seen_by.agent_from_camera)[:3, :3]
    ahead, left, up = np.moveaxis(pixel_rays(finer) @ to_world.T, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        y, z = PLATE_M * left / ahead, PLATE_M * up / ahead
    hit = (ahead > 0) & (y > EDGE_M[0] + EDGE_M[1] * z) & (np.abs(z) < 4) & (y < 6)
    return hit.reshape(seen_by.height_px, FINER, seen_by.width_px, FINER).mean(axis=(1, 3))


@pytest.mark.gl
@pytest.mark.parametrize("name", SEEN_BY)
def test_an_edge_lies_within_a_twentieth_of_a_pixel_of_the_closed_form(name: str) -> None:
    seen_by = SEEN_BY[name]
    far = EDGE_M[0] + EDGE_M[1] * np.array([-4.0, 4.0])
    corners = [(PLATE_M, far[0], -4.0), (PLATE_M, 6.0, -4.0), (PLATE_M, 6.0, 4.0), (PLATE_M, far[1], 4.0)]
    plate = replace(quad((0, 0, 0), (0, 1, 0), (0, 0, 1)), vertices_m=np.array(corners, np.float32))
    place = world([plate], [matte(emission_cd_m2=np.ones(3))])
    take = partial(MODERNGL.capture, standing(place, AGENT), exposure=Exposure())
    (view,) = captured(MODERNGL, rig(seen_by), take).views
    light = view.luminance_cd_m2[0, ..., 0].astype(np.float64)
    expected = covered(seen_by)
    # How far the edge is off in a row is the light around it that is too much.
    rows = np.flatnonzero(((expected > 0) & (expected < 1)).any(axis=1))
    middle = seen_by.height_px // 2
    rows = rows[np.abs(rows - middle) < 0.3 * seen_by.height_px]
    assert len(rows) > 0.5 * seen_by.height_px
    columns = np.arange(seen_by.width_px)
    off_px = []
    for row in rows:
        edge = columns[(expected[row] > 0) & (expected[row] < 1)].max()  # the others are the plate's far end
        near = np.abs(columns - edge) < 8
        off_px.append(light[row, near].sum() - expected[row, near].sum())
    # A single row is off by what antialiasing blends of it.
    assert np.abs(off_px).max() < 0.25
    assert np.abs(np.convolve(off_px, np.ones(ROWS) / ROWS, "valid")).max() < 0.05
