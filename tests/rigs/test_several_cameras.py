"""Rigs of several cameras: where they look, what they cost, and what they have in view together."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tacos_framework.camera.geometry import agent_from_camera
from tacos_framework.testing import RigConformance, TaskConformance
from tacos_framework.testing.samples import sample_capture
from tacos_framework.values import Camera, FrameBatch, Lens
from tacos_plugins.rigs.front_back_sides import FrontBackSidesRig
from tacos_plugins.rigs.ring import RingRig
from tacos_plugins.rigs.several_cameras import Outlook, covered_deg
from tacos_plugins.tasks.surround_coverage import SurroundCoverage, covered_share

SENSOR = {"name": "test", "width_px": 640, "height_px": 480, "pixel_um": 3.0, "power_w": 1.5}


def ring(**variables):
    return RingRig.Variables(sensor=SENSOR, **variables)


class TestRingRig(RigConformance):
    component = RingRig
    variables = {"cameras": 5, "hfov_deg": 80.0, "sensor": SENSOR}  # noqa: RUF012


class TestFrontBackSidesRig(RigConformance):
    component = FrontBackSidesRig
    variables = {"front_hfov_deg": 60.0, "sensor": SENSOR}  # noqa: RUF012


class TestSurroundCoverage(TaskConformance):
    component = SurroundCoverage


def test_a_ring_looks_outwards_evenly():
    rig = RingRig(RingRig.Config(radius_m=0.2)).build(ring(cameras=4, hfov_deg=90, first_yaw_deg=90))
    ahead = [camera.agent_from_camera[:3, 2] for camera in rig.cameras]
    np.testing.assert_allclose(ahead, [[0, 1, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0]], atol=1e-12)
    places = [camera.agent_from_camera[:3, 3] for camera in rig.cameras]
    np.testing.assert_allclose(places, 0.2 * np.array(ahead), atol=1e-12)


def test_pixels_and_power_are_those_of_all_cameras():
    derived = RingRig(RingRig.Config()).derived(ring(cameras=3, hfov_deg=90))
    assert derived["total_megapixels"] == pytest.approx(3 * 0.3072)
    assert derived["total_power_w"] == 4.5
    unknown = {key: value for key, value in SENSOR.items() if key != "power_w"}
    variables = RingRig.Variables(cameras=3, hfov_deg=90, sensor=unknown)
    assert "total_power_w" not in RingRig(RingRig.Config()).derived(variables)


@given(
    st.lists(st.tuples(st.floats(-720, 720), st.floats(1, 179)), min_size=1, max_size=6),
)
def test_the_angle_in_view_is_that_of_counted_directions(given_):
    outlooks = [Outlook(str(i), yaw, field) for i, (yaw, field) in enumerate(given_)]
    at = np.arange(0, 360, 0.1) + 0.05
    seen = [np.abs((at - each.yaw_deg + 180) % 360 - 180) <= each.hfov_deg / 2 for each in outlooks]
    assert covered_deg(outlooks) == pytest.approx(np.any(seen, axis=0).sum() * 0.1, abs=0.25 * len(outlooks))


@given(st.integers(1, 6), st.floats(-180, 180))
def test_a_ring_turned_by_its_spacing_has_the_same_coordinates(cameras, yaw_deg):
    rig = RingRig(RingRig.Config())
    turned = (yaw_deg + 360 / cameras + 180) % 360 - 180
    one, other = (
        rig.coordinates(ring(cameras=cameras, hfov_deg=50, first_yaw_deg=yaw)) for yaw in (yaw_deg, turned)
    )
    assert one == pytest.approx(other, abs=1e-6)


@pytest.mark.parametrize("cameras", [1, 2, 4])
def test_narrow_bands_are_covered_as_the_angle_around(cameras):
    variables = ring(cameras=cameras, hfov_deg=70)
    rig = RingRig(RingRig.Config()).build(variables)
    share = covered_share(rig.cameras, elevation_deg=10, least_px_per_deg=0)
    assert share == pytest.approx(cameras * 70 / 360, abs=0.02)


def test_too_few_pixels_to_the_degree_cover_nothing():
    rig = RingRig(RingRig.Config(binning=2)).build(ring(cameras=4, hfov_deg=90))  # 5.6 px/deg on the axis
    assert covered_share(rig.cameras, elevation_deg=10, least_px_per_deg=5) > 0.95
    assert covered_share(rig.cameras, elevation_deg=10, least_px_per_deg=12) == 0


@pytest.mark.parametrize("half_field_deg", [60, 100])
def test_a_fisheye_covers_all_directions_up_to_its_field(half_field_deg):
    """A cap about the axis, of the band of a height of sin 80 deg to both sides, and 5 px/deg all over it."""
    radius_px = 5 * half_field_deg
    lens = Lens("equidistant", half_field_deg=half_field_deg)
    focal_px = radius_px / np.radians(half_field_deg)
    camera = Camera(
        "fisheye",
        2 * radius_px + 2,
        2 * radius_px + 2,
        pixel_um=1.0,
        focal_length_mm=focal_px * 1e-3,
        lens=lens,
        agent_from_camera=agent_from_camera((0, 0, 0), 0),
    )
    share = covered_share([camera], elevation_deg=90, least_px_per_deg=0)
    assert share == pytest.approx((1 - np.cos(np.radians(half_field_deg))) / 2, abs=0.01)
    assert covered_share([camera], elevation_deg=90, least_px_per_deg=5.1) == 0


def test_a_zone_is_covered_by_its_share_in_view():
    """Of 1 to 3 m ahead and up to 3 m aside a camera of 90 deg sees what is farther ahead than aside."""
    camera = Camera(
        "c", 400, 4000, pixel_um=1.0, focal_length_mm=0.2, agent_from_camera=agent_from_camera((0, 0, 0), 0)
    )
    zone = ((1.0, 0.0, -0.2), (3.0, 3.0, 0.2))
    assert covered_share([camera], 30, 0, zone=zone) == pytest.approx(4 / 6, abs=0.03)
    with pytest.raises(ValidationError, match="least ahead, left and up first"):
        SurroundCoverage.Config(zone=zone[::-1])


def test_things_outside_the_zone_are_not_seen():
    capture = sample_capture()
    far, near = (
        (
            (0.1, -50.0, -50.0),
            (1e3, 50.0, 50.0),
        ),
        ((0.01, -0.01, -0.01), (0.02, 0.01, 0.01)),
    )
    frames = FrameBatch(capture, tuple(np.zeros((*v.depth_m.shape, 1), np.uint8) for v in capture.views))
    seen = []
    for zone in (None, far, near):
        scorer = SurroundCoverage(SurroundCoverage.Config(zone=zone, within_m=1e3)).begin(state=None)
        scorer.update(frames)
        seen.append(scorer.scores()["things_seen"])
    assert seen[0] == seen[1] > seen[2] == 0


@pytest.mark.parametrize(
    ("component", "given_"),
    [
        (RingRig, {"cameras": 3, "hfov_deg": 80.0}),
        (FrontBackSidesRig, {"front_hfov_deg": 60.0, "other_hfov_deg": 110.0}),
    ],
)
def test_the_field_of_view_is_that_of_what_is_read_out(component, given_):
    """A smaller region behind a shorter lens: fewer pixels and watts of the rig's budget, the same angles."""
    builder = component(component.Config())
    whole, part = (
        component.Variables(sensor=SENSOR, **given_, **read_out)
        for read_out in ({}, {"roi_width": 0.5, "roi_height": 0.25, "sensor_binning": 2})
    )
    cameras, cropped = builder.build(whole).cameras, builder.build(part).cameras
    assert [camera.hfov_deg for camera in cropped] == pytest.approx([camera.hfov_deg for camera in cameras])
    assert {(camera.width_px, camera.height_px) for camera in cropped} == {(160, 60)}
    derived, of_all = builder.derived(part), builder.derived(whole)
    assert derived["total_megapixels"] == pytest.approx(of_all["total_megapixels"] / 32)
    assert derived["covered_deg"] == of_all["covered_deg"]
    assert derived["hfov_deg"] == pytest.approx(of_all["hfov_deg"])
