"""Renderers without OpenGL show what moves where it is, and a world in which there is nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_worlds import camera, moving_plate, pose, rig, standing, world

from tacos_framework.values import Exposure, View
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.renderers.mitsuba.renderer import MitsubaRenderer

NAMES = ("analytic", "mitsuba")


def view_of(name: str, episode: Any, seen_by: Any, **config: Any) -> View:
    if name == "mitsuba":
        pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")
        renderer: Any = MitsubaRenderer(MitsubaRenderer.Config(samples=4, **config))
    else:
        renderer = AnalyticRenderer(AnalyticRenderer.Config())
    (view,) = renderer.capture(episode, rig=rig(seen_by), exposure=Exposure(time_s=0.04)).views
    return view


@pytest.mark.parametrize("name", NAMES)
def test_things_that_move_are_seen_where_they_are(name):
    view = view_of(name, moving_plate(), camera(200, 60, 100.0))
    for frame in range(3):
        rows, columns = np.nonzero(view.object_id[frame] == 1)
        # 1 m wide at 10 m and 100 px focal length: 10 px, its middle 10 px further right each second.
        assert columns.mean() == pytest.approx(99.5 + 10 * frame, abs=0.51)
        assert view.depth_m[frame][rows, columns] == pytest.approx(np.full(len(rows), 10.0), rel=1e-5)
        bright = np.nonzero(view.luminance_cd_m2[frame, ..., 0] > 50)[1]
        assert bright.mean() == pytest.approx(99.5 + 10 * frame, abs=0.51)


def test_what_moves_is_blurred_by_its_own_motion():
    view = view_of("mitsuba", moving_plate(2)[1:], camera(200, 60, 1000.0), motion_samples=4)
    row = view.luminance_cd_m2[0, 30, :, 0]
    assert 3 <= np.count_nonzero((row > 1) & (row < 99)) <= 5  # 1 m/s over 40 ms at 10 m and 1000 px: 4 px


@pytest.mark.parametrize("name", NAMES)
def test_where_there_is_nothing_the_surroundings_are_seen(name):
    place = world([], ambient_cd_m2=2.0)
    view = view_of(name, standing(place, pose((0.0, 0.0, 2.0), (1.0, 0.0, 0.0))), camera(4, 3, 4.0))
    np.testing.assert_allclose(view.luminance_cd_m2, 2.0, rtol=1e-5)
    assert np.isinf(view.depth_m).all()
    assert not view.object_id.any()
