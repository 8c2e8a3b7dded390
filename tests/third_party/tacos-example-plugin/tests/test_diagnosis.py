"""The components in a diagnosis of captures: the effect is named, and the sensor simulates them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from tacos_framework import Camera, Exposure, ImageContext, ImageGeometry, Plugins, ProcedureRecipe, run
from tacos_gap.captures import Noise, RealCapture, write_captures
from tacos_gap.hypotheses.candidates import candidates

from tacos_example.haze import Haze
from tacos_example.monochrome import MonochromeSensor

WIDTH, HEIGHT = 160, 120
GEOMETRY = ImageGeometry(WIDTH, HEIGHT, 333.0, ((WIDTH - 1) / 2, (HEIGHT - 1) / 2), pixel_um=3.0)
CAMERA = Camera("camera", WIDTH, HEIGHT, pixel_um=3.0, focal_length_mm=0.999)
EXPOSURE = Exposure(0.010, gain_db=0.0)
EXTINCTION_PER_M = 0.04
CONSIDERED = {"haze", "exposure-error", "defocus", "black-level", "read-noise"}
SENSOR = MonochromeSensor(MonochromeSensor.Config(full_well_e=2000, read_noise_e=5))


def captures(haze: Haze) -> list[RealCapture]:
    """A dark, flats, and squares on walls at 2 to 20 m, by a camera that stands in hazy air."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    squares = 30 + 140.0 * (((rows + columns // 10) // 12 + (columns - rows // 10) // 12) % 2)
    depth_m = np.where(columns < 40, 2.0, np.where(columns < 80, 6.0, np.where(columns < 120, 12.0, 20.0)))
    levels = {"dark": ("dark", 0.0), "half": ("flat", 60.0), "bright": ("flat", 150.0)}
    shots = [_taken(name, kind, np.full((HEIGHT, WIDTH), level)) for name, (kind, level) in levels.items()]
    return [*shots, _taken("walls", "scene", squares, haze, depth_m)]


def _taken(name: str, kind: str, expected: Any, haze: Haze | None = None, depth_m: Any = None) -> RealCapture:
    context = ImageContext(exposure_s=EXPOSURE.time_s, white_level_dn=255, depth_m=depth_m)
    expected = expected.astype(np.float32)[None, :, :, None]
    rng = np.random.default_rng(len(name))
    seen = expected
    if haze is not None:
        seen = haze.on_array(expected, geometry=GEOMETRY, context=context, rng=rng)
    drawn = [SENSOR.draw(seen, camera=CAMERA, exposure=EXPOSURE, rng=rng) for _ in range(3)]
    return RealCapture(
        id=name,
        kind=kind,
        real_dn=np.clip(np.rint(np.concatenate(drawn)), 0, 255).astype(np.float32),
        expected_dn=expected,
        valid=np.ones((HEIGHT, WIDTH), bool),
        geometry=GEOMETRY,
        context=context,
        noise=Noise((255 / 2000,), ((5 * 255 / 2000) ** 2,)),
    )


def diagnosed(folder: Path, **settings: Any) -> dict[str, Any]:
    write_captures(folder / "captures", captures(Haze(Haze.Config(extinction_per_m=EXTINCTION_PER_M))))
    run(
        ProcedureRecipe("procedure.diagnose", {"captures": str(folder / "captures"), **settings}),
        out=folder / "out",
    )
    found: dict[str, Any] = json.loads((folder / "out" / "diagnosis.json").read_text("utf-8"))
    return found


def test_the_effect_is_named_with_its_parameter(tmp_path: Path) -> None:
    found = diagnosed(tmp_path)
    assert [cause["effect"] for cause in found["causes"]] == ["haze"]
    assert found["verdict"] == "explained"
    parameter = found["causes"][0]["parameters"]["extinction_per_m"]
    assert abs(parameter["value"] / EXTINCTION_PER_M - 1) < 0.05
    assert "effect.haze" in (tmp_path / "out" / "patched.yaml").read_text("utf-8")


def test_the_sensor_simulates_the_captures(tmp_path: Path) -> None:
    sensor = {"use": "sensor.monochrome", "full_well_e": 2000, "read_noise_e": 5}
    without = sorted(set(candidates(Plugins.discover()).effects) - CONSIDERED)
    found = diagnosed(tmp_path, sensor=sensor, without=without)
    assert [cause["effect"] for cause in found["causes"]] == ["haze"]
