"""The effects do what the framework relies on, what the lens does, and run in a recipe."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from tacos_framework import ContextMissing, ImageContext, ImageGeometry
from tacos_framework.testing import EffectConformance

from tacos_lens_prescription.distortion import PrescriptionDistortion
from tacos_lens_prescription.field import field_of
from tacos_lens_prescription.image import PrescriptionImage, blurred

RECIPE = Path(__file__).parents[1] / "recipes" / "robot_triplet.yaml"
AXIS = ImageGeometry(801, 3, focal_length_px=1000.0, centre_px=(400.0, 1.0), pixel_um=3.0)
RNG = np.random.default_rng(1)


class TestPrescriptionDistortion(EffectConformance):
    component = PrescriptionDistortion
    config = {"share": 1.0}


class TestPrescriptionImage(EffectConformance):
    component = PrescriptionImage
    config = {"share": 1.0}


def test_a_pixel_of_the_triplet_looks_where_its_chief_ray_comes_from() -> None:
    """20 degrees are imaged at 18.1360 of 49.9998 mm, but for 2.5 um or .05 px of pupil aberration."""
    effect = PrescriptionDistortion(PrescriptionDistortion.Config(share=1.0))
    columns, _ = effect.source(geometry=AXIS, context=ImageContext(), frames=1)
    seen = np.interp(400 + 1000 * 18.136026 / 49.999783, np.arange(801), columns[1])
    assert seen == pytest.approx(400 + 1000 * np.tan(np.radians(20)), abs=0.06)


def test_blur_has_the_variance_asked_for_and_loses_no_light() -> None:
    light = np.zeros((1, 61, 61, 1))
    light[0, 30, 30] = 1.0
    sigma_px = np.full((61, 61), 1.7)
    sigma_px[0] = 4.0  # some row is blurred more, so that 1.7 px is a mixture
    spot = blurred(light, sigma_px)[0, ..., 0]
    off = np.arange(61) - 30
    assert spot.sum() == pytest.approx(1.0, rel=1e-3)
    assert spot.sum(axis=0) @ off**2 == pytest.approx(1.7**2, rel=0.03)


def test_it_is_as_dark_as_the_lens_and_black_beyond_its_field() -> None:
    wide = ImageGeometry(801, 3, focal_length_px=100.0, centre_px=(400.0, 1.0), pixel_um=3.0)
    effect = PrescriptionImage(PrescriptionImage.Config(share=1.0))
    seen = effect.on_array(
        np.ones((1, 3, 801, 1)), geometry=wide, context=ImageContext(f_number=5.0), rng=RNG
    )[0, 1, :, 0]
    assert seen[400] == pytest.approx(1.0, abs=1e-3)
    at_18_deg = 400 + int(100 * np.tan(np.radians(18)))
    assert seen[at_18_deg] == pytest.approx(field_of("", 5.0).light[18], rel=0.02)
    assert seen[0] == seen[800] == 0


def test_without_an_f_number_it_says_what_is_missing() -> None:
    effect = PrescriptionImage(PrescriptionImage.Config(share=1.0))
    with pytest.raises(ContextMissing, match="f-number"):
        effect.on_array(np.ones((1, 3, 801, 1)), geometry=AXIS, context=ImageContext(), rng=RNG)


def test_its_recipe_is_checked_and_renders(tmp_path: Path) -> None:
    subprocess.run(["tacos-run", RECIPE, "--check"], check=True)
    small = [
        *("--set", "optimizer.evaluations=1", "--set", "nodes.world.frames=1", "--set", "rig.binning=16"),
        *("--set", "study.episodes=1", "--set", "test=null"),
    ]
    subprocess.run(["tacos-run", RECIPE, "--quiet", "--out", tmp_path / "run", *small], check=True)
    assert "robot" in (tmp_path / "run" / "report.html").read_text("utf-8")
