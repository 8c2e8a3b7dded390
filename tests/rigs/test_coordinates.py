"""The coordinates of the rigs: what images depend on."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.rigs.stereo import StereoRig

FLEA3 = {"name": "IMX172", "width_px": 4000, "height_px": 3000, "pixel_um": 1.55}


def monocular(sensor=FLEA3, **variables):
    variables = {"focal_length_mm": 3.6, "sensor": sensor, **variables}
    return MonocularRig(MonocularRig.Config()).coordinates(MonocularRig.Variables(**variables))


def stereo(**variables):
    return StereoRig(StereoRig.Config()).coordinates(StereoRig.Variables(sensor=FLEA3, **variables))


def test_those_of_the_flea3():
    assert monocular(pitch_deg=-5) == {
        "pitch_deg": -5,
        "hfov_deg": pytest.approx(81.46, abs=0.01),
        "vfov_deg": pytest.approx(65.71, abs=0.01),
        "log2_width_px": pytest.approx(math.log2(4000)),
        "log2_height_px": pytest.approx(math.log2(3000)),
        "log2_pixel_um": pytest.approx(math.log2(1.55)),
        "line_time_us": 0,
        "mono": 0,
    }


@pytest.mark.parametrize(
    ("sensor", "line_time_us", "mono"),
    [
        ({"shutter": "rolling", "row_time_us": 18.9, "colour": "mono"}, 18.9, 1),
        ({"shutter": "rolling (global reset)"}, 15, 0),
        ({"shutter": "global", "row_time_us": 9.1, "colour": "colour"}, 0, 0),
    ],
)
def test_sensors_of_one_size_differ_in_shutter_and_filters(sensor, line_time_us, mono):
    found = monocular({**FLEA3, **sensor})
    assert (found["line_time_us"], found["mono"]) == (line_time_us, mono)


@given(scale=st.floats(0.25, 4))
def test_a_sensor_and_lens_of_another_size_differ_in_the_pitch_of_the_pixels_alone(scale):
    """A camera enlarged as a whole takes the same picture, but for its noise."""
    plain, enlarged = monocular(), monocular({**FLEA3, "pixel_um": 1.55 * scale}, focal_length_mm=3.6 * scale)
    assert enlarged.pop("log2_pixel_um") - plain.pop("log2_pixel_um") == pytest.approx(math.log2(scale))
    assert enlarged == pytest.approx(plain)


def test_a_stereo_rig_adds_the_logarithm_of_its_baseline_whichever_way_its_lens_is_given():
    by_field = stereo(baseline_m=0.5, hfov_deg=72)
    assert by_field["log2_baseline_m"] == -1
    focal_length_mm = 6.2 / (2 * math.tan(math.radians(36)))
    assert stereo(baseline_m=0.5, focal_length_mm=focal_length_mm) == pytest.approx(by_field)
