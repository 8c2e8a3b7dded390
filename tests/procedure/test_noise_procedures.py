"""Calibrating and validating noise: from files, rendered, and what is refused."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_framework.plugins import Plugins
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_framework.study.progress import Silent
from tacos_plugins.noise_calibration.calibrate import CalibrateNoise
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.sensors.calibration import load_calibration
from tacos_validation.noise.validate import ValidateNoise

PHOTON, THERMAL = np.array([0.24, 0.12, 0.29]), np.array([1.82, 0.91, 3.2])
CAMERA = {"sensor": "IMX172", "pixel_um": 1.55, "exposure_ms": 30, "gain_db": 15, "bit_depth": 8}
BENCH = {"renderer": {"use": "renderer.analytic"}, "frames": 12}
RIG = {
    "use": "rig.monocular",
    "focal_length_mm": 1.8,
    "sensor": {"name": "IMX172", "width_px": 320, "height_px": 160, "pixel_um": 1.55},
}
AFFINE = {"use": "sensor.affine-noise", "calibration": "flea3_imx172", "responsivity_dn_per_lux_s": 68}


def colour_bars(frames: int = 10, *, scale: float = 1.0, seed: int = 1, size=(120, 240)) -> np.ndarray:
    """(F, H, W, 3) float frames of 12 grey bars with the noise of the Flea3, in its DN times `scale`."""
    rng = np.random.default_rng(seed)
    signal = np.repeat(np.linspace(0, 200, 12), size[1] // 12)[None, :, None] * np.ones((size[0], 1, 3))
    noise = rng.standard_normal((frames, *signal.shape)) * np.sqrt(PHOTON * signal + THERMAL)
    return np.maximum(np.rint((signal + noise) * scale), 0)


def calibrate(out: Path, **config) -> dict:
    procedure = CalibrateNoise(CalibrateNoise.Config(**config))
    return dict(procedure.run(out=out, seed=1, plugins=Plugins.discover(), progress=Silent()))


def assert_found(result: dict, scale: float = 1.0, tolerance: float = 1.6) -> None:
    """Every figure within so many half widths of its 95 % interval."""
    for i, found in enumerate(result["channels"].values()):
        for name, truth in (("photon_dn", PHOTON[i] * scale), ("thermal_dn2", THERMAL[i] * scale**2)):
            low, high = found[name]["ci"]
            assert abs(found[name]["value"] - truth) < tolerance * (high - low) / 2, (i, name)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "frames").mkdir()
    return tmp_path / "frames"


def write(folder: Path, frames: np.ndarray, form: str) -> None:
    for i, frame in enumerate(frames):
        path = folder / f"{i:03}.{form}"
        if form == "npy":
            np.save(path, frame)
        else:
            cv2.imwrite(str(path), frame if frame.ndim == 2 else np.ascontiguousarray(frame[..., ::-1]))


@pytest.mark.parametrize("form", ["png", "tiff", "npy"])
@pytest.mark.parametrize("bits", [8, 12])
def test_frames_on_disk_give_back_the_noise_that_went_in(folder, tmp_path, form, bits):
    scale = 2.0 ** (bits - 8)
    write(folder, colour_bars(scale=scale).astype(np.uint8 if bits == 8 else np.uint16), form)
    result = calibrate(tmp_path, frames=str(folder), camera={**CAMERA, "bit_depth": bits})
    assert list(result["channels"]) == ["R", "G", "B"]
    assert_found(result, scale)


def test_a_glob_names_frames_too(folder, tmp_path):
    write(folder, colour_bars().astype(np.uint8), "png")
    (folder / "notes.txt").write_text("not a frame")
    result = calibrate(tmp_path, frames=str(folder / "00[0-7].png"), camera=CAMERA)
    assert result["frames"] == 8


@pytest.mark.parametrize("mosaic", ["RGGB", "GBRG"])
def test_a_bayer_mosaic_is_taken_apart(folder, tmp_path, mosaic):
    whole = colour_bars(size=(240, 480)).astype(np.uint8)
    frames = np.empty(whole.shape[:3], np.uint8)
    for place, colour in enumerate(mosaic):
        rows, columns = np.s_[place // 2 :: 2], np.s_[place % 2 :: 2]
        frames[:, rows, columns] = whole[:, rows, columns, "RGB".index(colour)]
    write(folder, frames, "png")
    result = calibrate(tmp_path, frames=str(folder), camera={**CAMERA, "cfa": mosaic})
    assert_found(result)


@pytest.mark.parametrize("dtype", ["<u2", ">u2", "<i4", ">f8"])
def test_the_byte_order_and_type_of_whole_numbers_do_not_matter(folder, tmp_path, dtype):
    write(folder, colour_bars(scale=16).astype(dtype), "npy")
    assert_found(calibrate(tmp_path, frames=str(folder), camera={**CAMERA, "bit_depth": 12}), 16)


def test_frames_of_eight_bits_that_are_said_to_have_twelve_are_refused(folder, tmp_path):
    write(folder, colour_bars(2).astype(np.uint8), "png")
    with pytest.raises(UserError, match=r"000\.png has 8 bits, and bit_depth says 12"):
        calibrate(tmp_path, frames=str(folder), camera={**CAMERA, "bit_depth": 12})


def test_jpeg_frames_are_refused_with_the_reason(folder, tmp_path):
    write(folder, colour_bars(3).astype(np.uint8), "jpg")
    with pytest.raises(UserError) as raised:
        calibrate(tmp_path, frames=str(folder), camera=CAMERA)
    assert len(raised.value.faults) == 3
    assert "000.jpg is JPEG, whose coding smooths noise and follows a tone curve" in str(raised.value)


def test_averaged_frames_are_refused(folder, tmp_path):
    write(folder, colour_bars(2) + 0.5, "npy")
    with pytest.raises(UserError, match=r"000.npy holds numbers that are not whole \(float64\)"):
        calibrate(tmp_path, frames=str(folder), camera=CAMERA)


def test_mono_frames_make_a_mono_calibration(folder, tmp_path):
    write(folder, colour_bars().astype(np.uint8)[..., 1], "png")
    calibrate(tmp_path, frames=str(folder), camera=CAMERA)
    assert len(load_calibration(tmp_path / "calibration.yaml").photon_dn) == 1


def test_the_calibration_serves_the_sensor_and_is_as_bright_as_the_shipped_one(folder, tmp_path):
    write(folder, colour_bars().astype(np.uint8), "png")
    calibrate(tmp_path, frames=str(folder), camera=CAMERA)
    path = tmp_path / "calibration.yaml"
    assert set(read_yaml(path).data) == set(type(load_calibration(path)).model_fields)
    sensor = AffineNoise(AffineNoise.Config(calibration=str(path)))
    assert sensor.calibration.photon_dn == pytest.approx(PHOTON, rel=0.03)
    shipped = load_calibration("flea3_imx172")
    assert sensor.calibration.responsivity_dn_per_lux_s == pytest.approx(
        shipped.responsivity_dn_per_lux_s, rel=1e-3
    )


def test_rendered_frames_give_back_the_calibration_within_its_intervals(tmp_path):
    result = calibrate(
        tmp_path,
        rendering={
            "rig": RIG,
            "sensor": AFFINE,
            "exposure": {"exposure_ms": 30, "gain_db": 15},
            "bench": BENCH,
        },
    )
    assert_found(result)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "<svg" in page
    assert "data:image/png" in page
    assert "0.24 DN, 1.82 DN²" in page
    assert "http" not in page.replace("http-equiv", "")


def test_other_settings_are_predicted_and_compared(tmp_path):
    procedure = ValidateNoise(
        ValidateNoise.Config(
            bench=BENCH,
            cameras=(
                {
                    "title": "affine",
                    "rig": RIG,
                    "sensor": AFFINE,
                    "reference": "flea3_imx172",
                    "settings": ({"exposure_ms": 30, "gain_db": 15}, {"exposure_ms": 20, "gain_db": 12}),
                },
                {
                    "title": "electrons",
                    "rig": {**RIG, "sensor": {**RIG["sensor"], "full_well_e": 8000, "read_noise_e": 3.0}},
                    "sensor": {
                        "use": "sensor.emva",
                        "quantum_efficiency": 0.5,
                        "dark_current_e_s": 0,
                        "black_level_dn": 256,
                    },
                    "settings": (
                        {"exposure_ms": 6, "gain_db": 15, "f_number": 5.6},
                        {"exposure_ms": 8, "gain_db": 6, "f_number": 5.6},
                    ),
                },
            ),
        )
    )
    result = procedure.run(out=tmp_path, seed=2, plugins=Plugins.discover(), progress=Silent())
    second = result["cameras"]["affine"][1]["channels"]["G"]
    gain = 10 ** (-3 / 20)
    assert second["predicted"]["photon_dn"] == pytest.approx(0.12 * gain)
    assert second["predicted"]["thermal_dn2"] == pytest.approx(0.91 * gain**2)
    for checked in result["cameras"].values():
        for setting in checked:
            for channel in setting["channels"].values():
                assert abs(channel["slope_error"]) < 0.03
                assert channel["median_variance_error"] < 0.03
    first = result["cameras"]["electrons"][0]["channels"]["G"]
    gain_dn_per_e = 10 ** (15 / 20) * (4095 - 256) / 8000
    assert first["photon_dn"]["value"] == pytest.approx(gain_dn_per_e, rel=0.02)
    assert first["thermal_dn2"]["value"] == pytest.approx((3 * gain_dn_per_e) ** 2, rel=0.1)
    assert result["summary"].count("\n") == 1
    assert (tmp_path / "report.html").read_text("utf-8").count("<svg") == 4, "each once more for phones"


def refusal(folder: Path, out: Path, frames: np.ndarray | None, **camera) -> str:
    if frames is not None:
        write(folder, frames.astype(np.uint8), "png")
    with pytest.raises(UserError) as raised:
        calibrate(out, frames=str(folder), camera={**CAMERA, **camera})
    return str(raised.value)


def test_no_frames(folder, tmp_path):
    assert "there are no frames here" in refusal(folder, tmp_path, None)


def test_too_few_frames(folder, tmp_path):
    assert "there is 1 frame" in refusal(folder, tmp_path, colour_bars(1))


def test_a_scene_that_moves(folder, tmp_path):
    moving = np.stack([np.roll(frame, i, axis=1) for i, frame in enumerate(colour_bars())])
    message = refusal(folder, tmp_path, moving)
    assert "where brightness changes, pixels vary" in message
    assert "Fix the camera and the target" in message


def test_saturated_frames(folder, tmp_path):
    assert "reach 0 or the white level" in refusal(folder, tmp_path, np.full((5, 60, 60, 3), 255))


def test_copies_of_one_frame(folder, tmp_path):
    message = refusal(folder, tmp_path, np.repeat(colour_bars(1), 5, axis=0))
    assert "Copies of one file hold no noise" in message


def test_a_target_of_one_brightness(folder, tmp_path):
    even = 100 + 3 * np.random.default_rng(1).standard_normal((6, 80, 80, 3))
    assert "no line can be fitted" in refusal(folder, tmp_path, np.rint(even))


def test_files_that_do_not_match_are_named_together(folder, tmp_path):
    write(folder, colour_bars(2).astype(np.uint8), "png")
    np.save(folder / "z.npy", np.zeros((4, 4), np.float32))
    (folder / "y.png").write_bytes(b"no image")
    np.save(folder / "x.npy", np.zeros((4, 4), np.uint8))
    with pytest.raises(UserError) as raised:
        calibrate(tmp_path, frames=str(folder), camera=CAMERA)
    assert [Path(fault.where).name for fault in raised.value.faults] == ["x.npy", "y.png", "z.npy"]


def test_a_mosaic_of_colour_frames(folder, tmp_path):
    assert "cfa is RGGB, but the frames have 3 channels" in refusal(
        folder, tmp_path, colour_bars(2), cfa="RGGB"
    )


def test_doubts_are_told(folder, tmp_path):
    rng = np.random.default_rng(2)
    pattern = 1 + 0.1 * rng.standard_normal((120, 240, 1))
    frames = np.minimum(colour_bars(4) * pattern, 255)
    write(folder, np.rint(frames).astype(np.uint8), "png")
    result = calibrate(tmp_path, frames=str(folder), camera=CAMERA)
    warned = " ".join(result["warnings"])
    assert "There are 4 frames" in warned
    assert "effect.prnu simulates it" in warned


@pytest.mark.parametrize("config", [{}, {"frames": "somewhere"}])
def test_frames_come_from_somewhere(config):
    with pytest.raises(ValueError, match=r"either frames: .* or rendering:|frames also take camera:"):
        CalibrateNoise.Config(**config)


@pytest.mark.parametrize("name", ["calibrate_noise", "validate_noise"])
def test_the_shipped_recipes_have_no_faults(name):
    from tacos_framework.packaged_resources import shipped_recipes
    from tacos_framework.plan.procedure import plan_procedure
    from tacos_framework.recipe.procedure import procedure_from

    recipe, faults = procedure_from(read_yaml(shipped_recipes()[name]), {}, ())
    assert (
        plan_procedure(recipe, Plugins.discover(), faults).recipe.use == f"procedure.{name.replace('_', '-')}"
    )
