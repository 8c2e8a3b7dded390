"""The lens: its published focal length, the figures of another tracer, and laws that need no tracer."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from tacos_framework import UserError

from tacos_lens_prescription.field import traced
from tacos_lens_prescription.prescription import TRIPLET, Prescription, Surface, read_prescription

LENS = read_prescription(TRIPLET)
OPTILAND_MM = {
    "focal length": 49.99978307,
    "entrance pupil": 11.51215867,
    "height at 20 deg": 18.13602593,
    "sagittal spread": 0.00845742,
    "tangential spread": 0.00742444,
}
"""What optiland 0.6.3 computes for its `CookeTriplet` at 550 nm, an object at infinity and f/5: it
aims at the paraxial entrance pupil, the rays of the spot at a square grid of 64 x 64 points within it."""


def test_the_focal_length_is_the_published_one() -> None:
    assert LENS.focal_length_mm == pytest.approx(50.0, rel=1e-4)
    assert LENS.focal_length_mm == pytest.approx(OPTILAND_MM["focal length"], rel=1e-7)


def test_a_ball_has_the_focal_length_and_the_spherical_aberration_of_textbooks() -> None:
    """EFL n D / (4 (n - 1)); a ray at height y leaves at an angle of 2 (asin y/R - asin y/nR)."""
    ball = Prescription((Surface(5.0, 10.0, 1.5, 5.0, True), Surface(-5.0, 2.5, 1.0, 5.0, False)))
    assert ball.focal_length_mm == pytest.approx(7.5)
    rays = ball.trace(np.array([[0.0, 3.0]]), 0.0)
    turned = 2 * (math.asin(3 / 5) - math.asin(3 / 7.5))
    assert rays.direction[0] == pytest.approx([0.0, -math.sin(turned), math.cos(turned)])


def test_rays_and_spots_are_those_of_another_tracer() -> None:
    angle = math.radians(20)
    centre_mm = np.array([0.0, -OPTILAND_MM["entrance pupil"] * math.tan(angle)])
    (image_mm,) = LENS.trace(centre_mm[None], angle).image_mm
    assert image_mm == pytest.approx([0.0, OPTILAND_MM["height at 20 deg"]], abs=1e-6)
    across_mm = np.linspace(-5, 5, 64)
    pupil_mm = np.column_stack([each.ravel() for each in np.meshgrid(across_mm, across_mm)])
    spot_mm = LENS.trace(centre_mm + pupil_mm[np.hypot(*pupil_mm.T) <= 5], angle).image_mm
    spread = [OPTILAND_MM["sagittal spread"], OPTILAND_MM["tangential spread"]]
    assert spot_mm.std(axis=0) == pytest.approx(spread, abs=1e-6)


def test_the_chief_ray_goes_through_the_middle_of_the_stop_itself() -> None:
    """That of the triplet misses the paraxial pupil by its aberration, micrometres in the image."""
    height_mm = traced(LENS, f_number=5.0).height[20] * LENS.focal_length_mm
    assert 1e-3 < abs(height_mm - OPTILAND_MM["height at 20 deg"]) < 5e-3


def test_the_figures_of_the_other_tracer_are_its_own() -> None:
    objectives = pytest.importorskip("optiland.samples.objectives", reason="pip install '.[tracer]'")
    triplet = objectives.CookeTriplet()
    assert triplet.paraxial.EPL() == pytest.approx(OPTILAND_MM["entrance pupil"], rel=1e-7)
    assert triplet.paraxial.f2() == pytest.approx(OPTILAND_MM["focal length"], rel=1e-7)
    chief = triplet.trace_generic(Hx=0, Hy=1, Px=0, Py=0, wavelength=0.55)
    assert float(chief.y[0]) == pytest.approx(OPTILAND_MM["height at 20 deg"], abs=1e-6)
    beam = triplet.trace(Hx=0, Hy=1, wavelength=0.55, num_rays=64, distribution="uniform")
    spreads = [OPTILAND_MM["sagittal spread"], OPTILAND_MM["tangential spread"]]
    assert [float(np.std(each)) for each in (beam.x, beam.y)] == pytest.approx(spreads, abs=1e-7)


@pytest.mark.parametrize("angle_deg", [5, 12, 20])
def test_the_fall_off_is_the_solid_angle_that_the_image_sees(angle_deg: int) -> None:
    """From the image's side: illuminance is luminance times the area of the beam in direction cosines."""
    ys = np.linspace(-12, 12, 401)
    grid = np.column_stack([each.ravel() for each in np.meshgrid(ys, ys)])
    seen = []
    for angle in (0.0, math.radians(angle_deg)):
        beam = LENS.trace(grid, angle, LENS.stop_radius_mm(5.0))
        seen.append(ConvexHull(beam.direction[beam.passed, :2]).volume)  # of a plane figure, its area
    assert traced(LENS, 5.0).light[angle_deg] == pytest.approx(seen[1] / seen[0], rel=0.015)


def test_a_stop_before_a_weak_lens_falls_off_as_the_fourth_power_of_the_cosine() -> None:
    weak = Prescription((Surface(1e4, 1e-3, 1.001, 500.0, True), Surface(-1e4, 5e6, 1.0, 500.0, False)))
    field = traced(weak, f_number=weak.focal_length_mm / 400)
    np.testing.assert_allclose(field.light[:40], np.cos(np.arctan(field.tangent[:40])) ** 4, rtol=0.01)


def test_all_that_is_wrong_with_a_table_is_said(tmp_path: Path) -> None:
    (table := tmp_path / "lens.csv").write_text(
        "radius_mm,thickness_mm,index,semi_diameter_mm,stop\n50,3,0.5,9,stop\n-50,three,1,9,\n"
    )
    with pytest.raises(UserError) as caught:
        read_prescription(table)
    assert [fault.where for fault in caught.value.faults] == [f"{table}:2", f"{table}:3"]
