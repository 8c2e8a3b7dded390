"""What ``--check`` says of lenses, and where."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.cli import run_main

CALIBRATION = """image_width: 640
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [300, 0, 319.5, 0, 300, 239.5, 0, 0, 1]}
distortion_model: equidistant
distortion_coefficients: {rows: 1, cols: 4, data: [0.01, 0, 0, 0]}
"""
RECIPE = """tacos: 1
name: lenses
rig:
  use: rig.stereo
  baseline_m: 0.1
  sensor: {{width_px: 640, height_px: 480, pixel_um: 3.0}}
{rig}
design: {{pitch_deg: {{between: [-30, 30]}}}}
scenario: {{illumination_lux: 20}}
nodes:
  world: {{use: scene.indoor, frames: 2}}
  capture: {{use: renderer.moderngl, in: {{episode: world}}}}
  frames: {{use: sensor.affine-noise, in: {{capture: capture}}}}
  features: {{use: task.orb-features, in: {{frames: frames}}}}
fitness: [{{score: features.inliers, weight: 1}}]
optimizer: {{use: optimizer.random, evaluations: 2}}
"""


def checked(tmp_path: Path, capsys: pytest.CaptureFixture[str], rig: str) -> tuple[int, str]:
    (tmp_path / "left.yaml").write_text(CALIBRATION)
    (tmp_path / "lens.yaml").write_text(RECIPE.format(rig=rig))
    code = run_main([str(tmp_path / "lens.yaml"), "--check"])
    captured = capsys.readouterr()
    return code, captured.out + captured.err


@pytest.mark.parametrize(
    ("rig", "line", "said"),
    [
        (
            "  hfov_deg: 190",
            7,
            "hfov_deg is a field of view of 190 deg, where a rectilinear lens has one below 180",
        ),
        (
            "  calibration: left.yaml\n  sensor_binning: 2",
            7,
            "is of images of 640 x 480 pixels, and this camera",
        ),
        ("  calibration: gone.yaml", 7, "gone.yaml"),
    ],
)
def test_lenses_that_cannot_be_are_refused_where_they_stand(tmp_path, capsys, rig, line, said):
    code, told = checked(tmp_path, capsys, rig)
    assert code == 2
    assert f"lens.yaml:{line}:" in told
    assert said in told


@pytest.mark.parametrize("rig", ["  calibration: left.yaml", "  hfov_deg: 190\n  projection: equidistant"])
def test_fisheyes_pass_wherever_the_command_is_typed(tmp_path, capsys, rig):
    code, told = checked(tmp_path, capsys, rig)
    assert (code, "no faults" in told) == (0, True), told


def test_dark_corners_are_said(tmp_path, capsys):
    code, said = checked(
        tmp_path, capsys, "  focal_length_mm: 0.579\n  projection: equidistant\n  image_circle_deg: 170"
    )
    assert code == 0
    assert "An image circle of 1.7 mm on a sensor of 1.9 x 1.4 mm leaves 2" in said
    assert "% of the image dark." in said
