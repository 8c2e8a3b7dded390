"""Glossy floors beside doors and shelves, against the path tracer: no white triangles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, uniform_filter
from small_worlds import box, camera, matte, panel, pose, quad, rig, room, standing, world

from tacos_framework.values import Exposure, Material
from tacos_plugins.renderers.light.probe_map import map_probes
from tacos_plugins.renderers.mitsuba.renderer import MitsubaRenderer
from tacos_plugins.renderers.moderngl import device
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")

FLOOR_M = (6.0, 2.0)  # half its size; two triangles that meet along a diagonal, through both rooms
WINDOW_PX = 5  # the path tracer's noise is averaged over such squares
BRIGHTEST = 2.0
"""Over the path tracer's luminance no place of the floor may be brighter than most of it by this factor."""


def two_rooms():
    """A bright and a dim room with a door between them, a shelf in the dim one, and a polished floor."""
    floor = quad((0, 0, 0.01), (FLOOR_M[0], 0, 0), (0, FLOOR_M[1], 0), 0, 1)
    shell = room((-6, -2, 0), (6, 2, 2.5), 1)
    beside_the_door = [
        *box((-0.05, -2, 0), (0.05, -0.5, 2.5), material=1),
        *box((-0.05, 0.5, 0), (0.05, 2, 2.5), material=1),
    ]
    shelf = box((-2.5, 1.4, 0), (-1.5, 2, 1.2), material=1, object_id=2)
    lamps = [panel((x, 0, 2.4), 0.5, flux_lm) for x, flux_lm in ((-3.0, 300.0), (3.0, 5000.0))]
    materials = [Material("polished", np.full(3, 0.2), roughness=0.3), matte(0.5)]
    return world([floor, *shell, *beside_the_door, *shelf], materials, lamps, indirect_lux=None)


def luminance(renderer, place):
    """(H, W) luminance [cd/m2] and where the floor is seen, a pixel off its edges."""
    at, through = pose((-5.0, 0.0, 1.3), (1.0, 0.0, -0.35)), camera(72, 54, 50.0)
    capture = renderer.capture(standing(place, at), rig=rig(through), exposure=Exposure())
    view = capture.views[0]
    return view.luminance_cd_m2[0].mean(axis=-1, dtype=np.float64), view.object_id[0] == 1


def brightest(ours, traced, floor):
    """How much brighter a place of the floor is than the path tracer's, over how much most of it is [1].

    Places that are too dark count for nothing: what a door shows far off is mirrored where it should be by
    the path tracer alone.
    """
    inner = binary_erosion(floor, np.ones((WINDOW_PX, WINDOW_PX)))
    ratio = uniform_filter(ours, WINDOW_PX)[inner] / uniform_filter(traced, WINDOW_PX)[inner]
    return ratio.max() / np.median(ratio)


def by_triangles(*arguments):
    """A map of probes as it was when each triangle mirrored the probe of its last vertex."""
    mapped = map_probes(*arguments)
    rows, columns = np.indices(mapped.first.shape)
    x, y = (
        mapped.origin_m[axis] + (index + 0.5) * mapped.cell_m for axis, index in ((0, columns), (1, rows))
    )
    bright = int(np.argmax(arguments[0][:, 0]))
    beyond_the_diagonal = y / FLOOR_M[1] < x / FLOOR_M[0]
    first = np.where(beyond_the_diagonal, bright, 1 - bright).astype(np.int32)
    return replace(mapped, first=first, share=np.zeros_like(mapped.share))


@pytest.mark.slow
@pytest.mark.gl
def test_no_false_triangles_beside_doors_and_shelves(monkeypatch):
    place = two_rooms()
    traced, floor = luminance(MitsubaRenderer(MitsubaRenderer.Config(samples=1024)), place)
    ours, _ = luminance(ModernglRenderer(ModernglRenderer.Config()), place)
    assert brightest(ours, traced, floor) < BRIGHTEST

    # The same with the fault put back, which shows that this would find it.
    monkeypatch.setattr(device, "map_probes", by_triangles)
    monkeypatch.setattr(device, "kept", lambda what, world, texel_m, make: make())
    faulty, _ = luminance(ModernglRenderer(ModernglRenderer.Config(light_texel_m=0.061)), place)
    assert brightest(faulty, traced, floor) > 1.25 * BRIGHTEST
