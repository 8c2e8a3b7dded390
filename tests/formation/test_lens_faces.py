"""Images through any lens, put together from pinholes: against rays cast one by one and closed forms."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from small_worlds import box, camera, matte, moving_plate, pose, quad, rig, room, standing, world

from tacos_framework.camera import along_axis_m, invert_pose, pixel_rays, pixels_of_rays, world_from_camera
from tacos_framework.formation import captured
from tacos_framework.values import Camera, Exposure, Lens
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

ANALYTIC = AnalyticRenderer(AnalyticRenderer.Config())
MODERNGL = ModernglRenderer(ModernglRenderer.Config(light_texel_m=0.3))
AGENT = pose((0.3, -0.2, 1.4), (0.9, 0.4, 0.05))
DARK, BRIGHT = matte(0.0), matte(0.0, emission_cd_m2=np.full(3, 9.0))

LENSES = {
    "equidistant 190": Lens("equidistant", half_field_deg=95),
    "equisolid 360": Lens("equisolid", half_field_deg=175),
    "stereographic 200": Lens("stereographic", half_field_deg=100),
    "T265": Lens("kannala-brandt", (-0.003, 0.054, -0.052, 0.011), 81.5),
    "barrel": Lens("rectilinear", (-0.2, 0.05, 0.001, -0.002)),
    "dark corners": Lens("rectilinear", half_field_deg=40),
}


class Pinholes:
    """Casts rays, and says nothing of lenses."""

    def capture(self, episode, *, rig, exposure):
        assert all(each.lens.is_pinhole for each in rig.cameras)
        return ANALYTIC.capture(episode, rig=rig, exposure=exposure)


def through(renderer, episode, *cameras):
    return captured(renderer, rig(*cameras), partial(renderer.capture, episode, exposure=Exposure())).views


def furnished():
    parts = room((-4, -4, 0), (4, 4, 3))
    for i, angle in enumerate(np.arange(0, 2 * np.pi, 0.5)):
        x, y = 2.5 * np.cos(angle), 2.5 * np.sin(angle)
        parts += box((x - 0.2, y - 0.2, 0.2), (x + 0.2, y + 0.2, 1 + 0.1 * i), 1, object_id=i + 1)
    return world(parts, [DARK, BRIGHT])


@pytest.mark.parametrize("name", LENSES)
def test_depth_and_ids_are_those_of_the_rays_of_the_lens(name):
    seen_by = camera(90, 80, 26.0, lens=LENSES[name])
    episode = standing(furnished(), AGENT)
    (cast,), (joined,) = (through(each, episode, seen_by) for each in (ANALYTIC, Pinholes()))
    seen = np.isfinite(cast.depth_m)
    np.testing.assert_array_equal(np.isfinite(joined.depth_m), seen)
    same = joined.object_id == cast.object_id
    assert same.mean() > 0.98  # what pixel centres see at borders is a matter of a fraction of a pixel
    off = np.abs(joined.depth_m / np.where(seen, cast.depth_m, 1) - 1)[seen & same]
    assert (
        off < 1e-3
    ).mean() > 0.75  # but for edges and surfaces seen at a glance: those of the nearest pixel
    assert np.quantile(off, 0.99) < 0.08
    np.testing.assert_array_equal(joined.world_from_camera, cast.world_from_camera)


@pytest.mark.parametrize("name", LENSES)
def test_beyond_the_image_circle_all_is_dark(name):
    seen_by = camera(90, 80, 26.0, lens=LENSES[name])
    dark = np.isnan(pixel_rays(seen_by)[..., 0])
    for renderer in (ANALYTIC, Pinholes()):
        (view,) = through(renderer, standing(world(room((-4, -4, 0), (4, 4, 3)), [BRIGHT]), AGENT), seen_by)
        assert (view.luminance_cd_m2[0][dark] == 0).all()
        assert np.isinf(view.depth_m[0][dark]).all()
        inside = view.luminance_cd_m2[0][~dark]
        np.testing.assert_allclose(inside, 9.0, rtol=1e-5)


def test_light_is_that_of_64_rays_a_pixel():
    seen_by = camera(48, 48, 16.5, lens=LENSES["equidistant 190"])
    episode = standing(furnished(), AGENT)
    fine = replace(seen_by, width_px=384, height_px=384, binning=1 / 8, principal_point_px=(191.5, 191.5))
    (cast,) = through(ANALYTIC, episode, fine)
    wanted = cast.luminance_cd_m2[0, ..., 0].reshape(48, 8, 48, 8).mean(axis=(1, 3))
    (view,) = through(MODERNGL, episode, seen_by)
    inside = np.isfinite(pixel_rays(fine)[..., 0]).reshape(48, 8, 48, 8).all(axis=(1, 3))
    off = (view.luminance_cd_m2[0, ..., 0] - wanted)[inside]
    assert abs(off.mean()) < 0.01 * 9
    assert np.sqrt((off**2).mean()) < 0.025 * 9


@pytest.mark.gl
@pytest.mark.parametrize("name", ["equidistant 190", "equisolid 360", "stereographic 200", "T265"])
def test_a_straight_edge_is_imaged_where_the_closed_form_has_it(name):
    """The tilted edge of a bright wall, across 100 degrees: within 0.05 px over any 10 columns.

    Single columns are as far off as the coverage of the renderer's own pixels, 0.1 px.
    """
    seen_by = camera(300, 260, 80.0, lens=LENSES[name])
    along = np.array([0.0, -1.0, -0.15]) / np.hypot(1, 0.15)
    up = np.array([0.0, -0.15, 1.0]) / np.hypot(1, 0.15)
    middle = np.array([2.0, 0.0, 0.5])
    eye = pose((0.0, 0.0, 0.0))
    wall = quad(middle - 2 * up, 40 * along, 2 * up)
    (view,) = through(MODERNGL, standing(world([wall], [BRIGHT]), eye), seen_by)
    light = view.luminance_cd_m2[0, :150, :, 0].astype(np.float64) / 9

    edge_m = middle + np.linspace(-3, 3, 4001)[:, None] * along
    camera_from_world = invert_pose(world_from_camera(eye, seen_by.agent_from_camera))
    x_px, y_px = pixels_of_rays(edge_m @ camera_from_world[:3, :3].T + camera_from_world[:3, 3], seen_by).T
    order = np.argsort(x_px)
    columns = np.arange(80, 220)
    within = columns[:, None] + np.linspace(-0.5, 0.5, 33)
    expected = np.interp(within, x_px[order], y_px[order]).mean(axis=1)
    off = 149.5 - light[:, columns].sum(axis=0) - expected
    assert abs(off.mean()) < 0.01
    assert np.abs(off.reshape(-1, 10).mean(axis=1)).max() < 0.05


def test_pinholes_beside_a_fisheye_are_as_they_are_alone():
    pinhole, fisheye = camera(), camera(name="fisheye", lens=LENSES["T265"])
    episode = standing(furnished(), AGENT)
    alone = through(Pinholes(), episode, pinhole)
    views = through(Pinholes(), episode, fisheye, pinhole)
    assert [view.camera.name for view in views] == ["fisheye", "camera"]
    np.testing.assert_array_equal(views[1].luminance_cd_m2, alone[0].luminance_cd_m2)


def test_all_frames_and_what_moves_in_them_pass_the_lens():
    seen_by = camera(201, 101, 90.0, lens=Lens("equidistant"))
    (view,) = through(MODERNGL, moving_plate(), seen_by)
    for frame in range(3):
        rows, columns = np.nonzero(view.object_id[frame] == 1)
        angle = np.arctan(0.1 * frame)
        assert columns.mean() == pytest.approx(100 + 90 * angle, abs=0.6)
        distance = along_axis_m(view.depth_m[frame], seen_by)[rows, columns]
        np.testing.assert_allclose(distance, 10.0, rtol=2e-3)


def test_opengl_refuses_to_draw_a_fisheye_as_a_pinhole():
    seen_by = Camera("c", 20, 20, 3.0, 0.02, lens=LENSES["T265"])
    with pytest.raises(ValueError, match="draws pinholes, not a kannala-brandt lens"):
        MODERNGL.capture(standing(furnished(), AGENT), rig=rig(seen_by), exposure=Exposure())
