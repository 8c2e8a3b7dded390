"""calibrate_camera: what went into simulated cameras, what was published of a real one, faults."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework.cli.run import main
from tacos_framework.errors import UserError
from tacos_framework.plugins import Plugins
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_framework.study.progress import Silent
from tacos_framework.testing import ProcedureConformance
from tacos_plugins.emva_calibration import intervals
from tacos_plugins.emva_calibration.calibrate import CalibrateCamera
from tacos_plugins.emva_calibration.data_sheet import data_sheet
from tacos_plugins.emva_calibration.frame_table import FrameGroup, read_frame_table
from tacos_plugins.emva_calibration.measurement import Channel
from tacos_plugins.emva_calibration.moments import difference, moments_of
from tests.procedure.simulated_emva import Camera1288

REAL = Path(__file__).parents[3] / "shared/data/real/emva_ccd12"


def calibrate(folder: Path, out: Path, **config) -> dict:
    procedure = CalibrateCamera(CalibrateCamera.Config(frames=str(folder), **config))
    return dict(procedure.run(out=out, seed=1, progress=Silent()))


def value(result: dict, name: str) -> float:
    return result[name]["value"]


def assert_near(result: dict, camera: Camera1288, rel: float = 0.03) -> None:
    assert value(result, "system_gain_dn_per_e") == pytest.approx(camera.gain, rel=rel)
    assert value(result, "quantum_efficiency") == pytest.approx(camera.efficiency, rel=rel)


@pytest.mark.skipif(not REAL.is_dir(), reason="the reference images of EMVA 1288 are not beside the checkout")
def test_the_reference_images_give_the_published_figures(tmp_path):
    result = calibrate(REAL, tmp_path)
    assert value(result, "system_gain_dn_per_e") == pytest.approx(0.281, rel=0.01)
    assert value(result, "quantum_efficiency") == pytest.approx(0.451, rel=0.02)
    assert value(result, "dark_noise_e") == pytest.approx(10.9, rel=0.1)
    assert value(result, "linearity_error_percent") < 1
    assert not any("not linear" in doubt or "lamp" in doubt for doubt in result["doubts"])


def test_a_camera_of_12_bits_gives_back_what_went_in(tmp_path):
    camera = Camera1288()
    result = calibrate(camera.write(tmp_path / "f", stack=16), tmp_path)
    assert_near(result, camera)
    assert value(result, "dark_noise_e") == pytest.approx(camera.noise_e, rel=0.03)
    assert value(result, "prnu_percent") == pytest.approx(1.0, rel=0.05)
    assert value(result, "dsnu_e") == pytest.approx(camera.dsnu_e, rel=0.1)
    assert value(result, "saturation_capacity_e") == pytest.approx((4095 - 60) / camera.gain, rel=0.08)
    assert value(result, "dark_current_e_s") == pytest.approx(400, rel=0.2)
    assert result["bit_depth"] == 12
    assert result["doubts"] == []
    low, high = result["quantum_efficiency"]["ci"]
    assert low < 0.5 < high
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "Overall system gain K" in page
    assert page.count("<svg") == 6


@pytest.mark.parametrize("form", [("npy", ">u2"), ("npy", "<i4"), ("png", ""), ("tiff", "")])
def test_files_and_byte_orders_give_the_same_figures(tmp_path, form):
    camera = Camera1288(size=(48, 64))
    expected = calibrate(camera.write(tmp_path / "e", levels=8), tmp_path)
    found = calibrate(camera.write(tmp_path / "f", levels=8, form=form[0], dtype=form[1]), tmp_path)
    assert found["levels"] == expected["levels"]


@pytest.mark.parametrize(("bits", "gain", "black"), [(8, 0.02, 6.0), (10, 0.08, 30.0), (16, 3.0, 900.0)])
def test_other_depths(tmp_path, bits, gain, black):
    camera = Camera1288(gain=gain, black=black, bits=bits)
    result = calibrate(camera.write(tmp_path / "f"), tmp_path)
    assert result["bit_depth"] == bits
    assert_near(result, camera)


def test_rounding_that_hides_dark_noise_gives_an_upper_limit(tmp_path):
    camera = Camera1288(gain=0.02, black=6.3, bits=8, noise_e=5.0)
    result = calibrate(camera.write(tmp_path / "f"), tmp_path)
    assert_near(result, camera, 0.05)
    assert result["dark_noise_e"]["ci"][0] == 0
    assert value(result, "dark_noise_e") == pytest.approx(0.40 / camera.gain, rel=0.05)
    assert any("below 0.24 DN²" in doubt for doubt in result["doubts"])


def test_samples_at_the_top_of_16_bits_are_counted_in_steps(tmp_path):
    camera = Camera1288(size=(48, 64))
    folder = camera.write(tmp_path / "f", levels=8)
    for path in folder.glob("*.npy"):
        np.save(path, np.load(path) * 16)
    result = calibrate(folder, tmp_path)
    assert_near(result, camera, 0.06)
    assert any("multiples of 16" in doubt for doubt in result["doubts"])


def test_colours_of_a_mosaic_are_measured_apart(tmp_path):
    camera = Camera1288(colours=np.array([[0.5, 1.0], [1.0, 0.7]]), size=(128, 160))
    folder = camera.write(tmp_path / "f")
    result = calibrate(folder, tmp_path, cfa="RGGB")
    assert result["channel"] == "G"
    assert_near(result, camera)
    assert value(result["channels"]["R"], "quantum_efficiency") == pytest.approx(0.25, rel=0.04)
    assert read_yaml(tmp_path / "sensor.yaml").data["channel_response"] == pytest.approx(
        [0.5, 1, 0.7], rel=0.05
    )
    assert any("set cfa=RGGB" in doubt for doubt in calibrate(folder, tmp_path)["doubts"])


def test_unknown_photons_leave_gain_and_dark_noise(tmp_path):
    camera = Camera1288()
    result = calibrate(camera.write(tmp_path / "f", photons_known=False), tmp_path)
    assert result["quantum_efficiency"]["value"] is None
    assert "photons_per_pixel is not given" in result["quantum_efficiency"]["reason"]
    assert value(result, "system_gain_dn_per_e") == pytest.approx(camera.gain, rel=0.03)
    assert value(result, "saturation_capacity_e") == pytest.approx(16140, rel=0.08)
    assert value(result, "linearity_error_percent") < 0.5


def test_darkness_cut_off_at_0_is_said_and_does_not_bend_the_gain(tmp_path):
    camera = Camera1288(black=0.0)
    result = calibrate(camera.write(tmp_path / "f"), tmp_path)
    assert_near(result, camera)
    for name in ("dark_noise_e", "dsnu_e", "dark_current_e_s"):
        assert result[name]["value"] is None
        assert "darkness is cut off" in result[name]["reason"]
    assert any("cut off at 0 DN" in doubt for doubt in result["doubts"])


def test_eight_bits_cut_out_of_twelve_keep_the_gain(tmp_path):
    camera = Camera1288(gain=0.25, black=14.0)
    folder = camera.write(tmp_path / "f", levels=24)
    for path in folder.glob("*.npy"):
        np.save(path, (np.load(path) >> 4).astype(np.uint8))
    table = folder / "frames.csv"
    table.write_text(table.read_text().replace("kind,exposure_ns,photons", "Kind,Exposure_ns,Photons"))
    result = calibrate(folder, tmp_path)
    assert value(result, "system_gain_dn_per_e") == pytest.approx(camera.gain / 16, rel=0.02)
    assert value(result, "quantum_efficiency") == pytest.approx(camera.efficiency, rel=0.02)


def test_columns_and_kinds_may_have_other_usual_names(tmp_path):
    camera = Camera1288(size=(48, 64))
    expected = calibrate(camera.write(tmp_path / "e", levels=8), tmp_path)
    table = camera.write(tmp_path / "f", levels=8) / "frames.csv"
    _, *lines = table.read_text().splitlines()
    rows = [line.replace("bright,", "Flat,", 1) for line in lines]
    table.write_text("\n".join(["Type,Exposure Time [ns],Photons,File Name", *rows]))
    assert calibrate(table.parent, tmp_path)["levels"] == expected["levels"]


def test_a_table_from_windows_may_have_paths_capitals_and_exposures_as_fractions(tmp_path):
    (tmp_path / "frames").mkdir()
    for name in ("a.png", "b.png"):
        (tmp_path / "frames" / name).touch()
    (tmp_path / "frames.csv").write_text(
        "kind,exposure_s,file\nbright,1/125,.\\frames\\A.PNG\ndark,0.008,frames\\b.png\n"
    )
    found = read_frame_table(tmp_path)
    assert not found.faults
    assert [(group.exposure_s, group.files) for group in found.groups] == [
        (0.008, (tmp_path / "frames/a.png",)),
        (0.008, (tmp_path / "frames/b.png",)),
    ]
    (tmp_path / "frames.csv").write_text(
        "kind,exposure_s,file\nbright,1,frames/a.png\ndark,1,Frames\\b.png\ndark,1,frames/A.png\n"
    )
    said = [fault.what for fault in read_frame_table(tmp_path).faults]
    assert said == ["there is no file 'Frames\\\\b.png'", "'frames/A.png' stands twice, as in 2"]


def test_levels_of_one_frame_that_leave_too_few_are_counted(tmp_path):
    folder = Camera1288(size=(32, 32)).write(tmp_path / "f", levels=4)
    table = folder / "frames.csv"
    lines = table.read_text().splitlines()
    table.write_text(
        "\n".join(line for line in lines if not line.endswith(tuple(f"bright{i}_1.npy" for i in (0, 1, 3))))
    )
    (message,) = refused(folder, tmp_path)
    assert "3 of 8 levels have one frame" in message


def test_bands_of_a_lamp_are_named_and_not_fitted(tmp_path):
    camera = Camera1288(bands=0.02)
    result = calibrate(camera.write(tmp_path / "f"), tmp_path)
    assert_near(result, camera)
    assert any("the lamp flickers" in doubt for doubt in result["doubts"])


def test_light_that_drifts_is_named_and_not_fitted(tmp_path):
    camera = Camera1288(drift=0.02)
    result = calibrate(camera.write(tmp_path / "f"), tmp_path)
    assert value(result, "system_gain_dn_per_e") == pytest.approx(camera.gain, rel=0.03)
    assert any("the light drifts or flickers" in doubt for doubt in result["doubts"])


def test_drift_of_light_is_no_part_of_prnu(tmp_path):
    camera = Camera1288(drift=0.03)
    result = calibrate(camera.write(tmp_path / "f", stack=16), tmp_path)
    assert value(result, "prnu_percent") == pytest.approx(1.0, rel=0.05)
    assert any("levels scatter about a straight line" in doubt for doubt in result["doubts"])
    assert not any("not linear" in doubt for doubt in result["doubts"])


def test_bands_in_step_with_the_exposures_are_named(tmp_path):
    folder = Camera1288().write(tmp_path / "f", stack=16)
    rows = 1 + 0.03 * np.sin(np.arange(96) / 7)[:, None]
    for path in folder.glob("bright*.npy"):
        frame = np.load(path)
        lit = np.where(frame < 4095, np.rint(60 + (frame - 60.0) * rows), frame)
        np.save(path, lit.clip(0, 4095).astype(np.uint16))
    result = calibrate(folder, tmp_path)
    assert_near(result, Camera1288())
    assert any("whole rows of bright frames differ by 2.1" in doubt for doubt in result["doubts"])


def test_frames_whose_two_bytes_are_exchanged_give_the_same_figures(tmp_path):
    camera = Camera1288(size=(48, 64))
    expected = calibrate(camera.write(tmp_path / "e", levels=8), tmp_path)
    folder = camera.write(tmp_path / "f", levels=8)
    for path in folder.glob("*.npy"):
        np.save(path, np.load(path).byteswap())
    found = calibrate(folder, tmp_path)
    assert found["levels"] == expected["levels"]
    assert any("in the wrong order" in doubt for doubt in found["doubts"])


def test_smoothed_frames_are_flagged_and_the_export_leaves_out_what_cannot_be(tmp_path):
    folder = Camera1288().write(tmp_path / "f")
    for path in folder.glob("*.npy"):
        np.save(path, cv2.GaussianBlur(np.load(path), (3, 3), 0.8))
    result = calibrate(folder, tmp_path)
    doubts = "\n".join(result["doubts"])
    assert "the noise of neighbouring pixels correlates (+0." in doubts
    assert "no camera gives more than one electron" in doubts
    assert "quantum_efficiency" not in read_yaml(tmp_path / "sensor.yaml").data


def test_a_stack_does_not_rule_the_line_of_a_camera_whose_darkness_is_cut_off(tmp_path):
    camera = Camera1288(black=0.0)
    folder = camera.write(tmp_path / "f", stack=24)
    fixed = np.random.default_rng(9)
    for path in folder.glob("bright_s_*.npy"):  # a stack as of 5 % more noise
        frame = np.load(path)
        noise = 0.32 * np.sqrt(0.25 * frame) * fixed.standard_normal(frame.shape)
        np.save(path, np.rint(frame + noise).clip(0, 4095).astype(np.uint16))
    assert_near(calibrate(folder, tmp_path), camera)


def test_a_tone_curve_is_flagged(tmp_path):
    camera = Camera1288(response=lambda dn: 4000 * (np.maximum(dn, 0) / 4000) ** 0.8)
    result = calibrate(camera.write(tmp_path / "f"), tmp_path)
    assert value(result, "linearity_error_percent") > 1
    assert any("the camera is not linear" in doubt for doubt in result["doubts"])


def test_a_camera_that_never_saturates_has_no_capacity(tmp_path):
    result = calibrate(Camera1288().write(tmp_path / "f", up=0.8), tmp_path)
    assert result["saturation_capacity_e"]["value"] is None
    assert "no level saturates" in result["saturation_capacity_e"]["reason"]


def test_the_export_serves_a_recipe(tmp_path):
    calibrate(Camera1288().write(tmp_path / "f"), tmp_path)
    settings = dict(read_yaml(tmp_path / "sensor.yaml").data)
    cls = Plugins.discover().resolve(settings.pop("use"))
    sensor = cls(cls.Config(**settings))
    assert sensor.config.system_gain_dn_per_e == pytest.approx(0.25, rel=0.03)
    assert sensor.config.read_noise_e == pytest.approx(8, rel=0.05)


def test_variance_of_a_difference_knows_no_fixed_pattern_and_no_bands():
    rng = np.random.default_rng(1)
    pattern = rng.uniform(500, 1500, (200, 200)).round()
    first, second = (
        (pattern + 9 * rng.standard_normal(pattern.shape) + shift).round().astype(np.uint16)
        for shift in (np.zeros((200, 1)), 40 * rng.standard_normal((200, 1)))
    )
    found = difference(first, second)
    assert found.variance_dn2 == pytest.approx(81 + 1 / 12, rel=0.03)
    assert found.bands_dn2 == pytest.approx(40**2 / 2, rel=0.3)


def test_intervals_cover_what_went_in(monkeypatch):
    """95 % intervals of 60 seeded calibrations; binomial chance leaves 51 to 60 with probability .998."""
    monkeypatch.setattr(intervals, "DRAWS", 250)  # their ends waver by a tenth of the error that they state
    camera = Camera1288(size=(32, 32), prnu=0.0, dsnu_e=0.0)
    full = (4095 - camera.black) / camera.gain / camera.efficiency
    truth = {"system_gain_dn_per_e": camera.gain, "quantum_efficiency": 0.5, "dark_noise_e": camera.noise_e}
    covered = dict.fromkeys(truth, 0)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        groups = []
        for share in np.linspace(0.03, 1.05, 20):
            for kind, photons in (("bright", share * full), ("dark", 0.0)):
                frames = camera.frames(photons, share * 0.01, 2, rng)
                group = FrameGroup(kind, share * 0.01, photons or None, "", ())
                groups.append((group, moments_of([[frame] for frame in frames])))
        sheet = data_sheet(Channel("mono", tuple(groups), (), 12, 1), "simulated", rng)
        for name, true in truth.items():
            low, high = sheet.figures[name].ci
            covered[name] += low <= true <= high
    assert all(51 <= count <= 60 for count in covered.values()), covered


def refused(folder: Path, out: Path, **config) -> list[str]:
    with pytest.raises(UserError) as raised:
        calibrate(folder, out, **config)
    return [str(fault) for fault in raised.value.faults]


def test_one_frame_a_level_is_refused_with_what_to_do(tmp_path):
    (message,) = refused(Camera1288(size=(32, 32)).write(tmp_path / "f", levels=4, per_level=1), tmp_path)
    assert "no bright level has two frames" in message
    assert "Take two bright frames at each level" in message


def test_copies_and_levels_under_one_name_are_told_together(tmp_path):
    folder = Camera1288(size=(32, 32)).write(tmp_path / "f", levels=4, photons_known=False)
    np.save(folder / "bright0_1.npy", np.load(folder / "bright0_0.npy"))
    np.save(folder / "bright1_1.npy", np.load(folder / "bright2_1.npy") + 1)
    np.save(folder / "dark1_1.npy", np.load(folder / "dark3_0.npy"))
    copy, mixed, dark = refused(folder, tmp_path)
    assert "bright0_1.npy: this frame is a copy of bright0_0.npy" in copy
    assert "dark3_0.npy: this frame is a copy of dark1_1.npy" in dark
    assert "differ in mean" in mixed
    assert "a column level" in mixed


def test_a_column_tells_levels_of_one_exposure_apart(tmp_path):
    camera = Camera1288(size=(48, 64))
    folder = camera.write(tmp_path / "f", levels=8, photons_known=False)
    lines = (folder / "frames.csv").read_text().splitlines()[1:]
    rows = [
        f"{line.split(',')[0]},10,{line.split(',')[3]},{line.split(',')[3].split('_')[0]}" for line in lines
    ]
    (folder / "frames.csv").write_text("kind,exposure_ms,file,level\n" + "\n".join(rows))
    result = calibrate(folder, tmp_path)
    assert value(result, "system_gain_dn_per_e") == pytest.approx(camera.gain, rel=0.05)
    assert result["linearity_error_percent"]["value"] is None


def test_frames_with_figures_of_their_own_are_of_one_level(tmp_path):
    camera = Camera1288(size=(48, 64))
    folder = camera.write(tmp_path / "f", levels=8)
    expected = calibrate(folder, tmp_path)
    head, *lines = (folder / "frames.csv").read_text().splitlines()
    apart = []
    for number, line in enumerate(lines):
        kind, exposure, photons, file = line.split(",")
        share = 1 + 0.0004 * (number % 2)
        measured = f"{float(photons) * share:.3f}" if kind == "bright" else photons
        apart.append(f"{kind},{float(exposure) * share:.1f},{measured},{file}")
    (folder / "frames.csv").write_text("\n".join([head, *apart]))
    found = calibrate(folder, tmp_path)
    assert value(found, "system_gain_dn_per_e") == pytest.approx(value(expected, "system_gain_dn_per_e"))
    assert value(found, "quantum_efficiency") == pytest.approx(
        value(expected, "quantum_efficiency"), rel=1e-3
    )


def test_all_faults_of_a_table_come_at_once(tmp_path):
    folder = Camera1288(size=(32, 32)).write(tmp_path / "f", levels=4)
    table = folder / "frames.csv"
    table.write_text(
        table.read_text() + "grey,10,5,bright0_0.npy\nbright,long,5,none.npy\ndark,3,7,dark1_0.npy\n"
    )
    told = "\n".join(refused(folder, tmp_path))
    for part in (
        "kind is 'grey'",
        "exposure_ns is 'long'",
        "there is no file 'none.npy'",
        "has 7 photons",
        "twice",
    ):
        assert part in told


def test_faults_of_the_table_and_of_files_come_together(tmp_path):
    folder = Camera1288(size=(32, 32)).write(tmp_path / "f", levels=4)
    table = folder / "frames.csv"
    table.write_text(table.read_text().replace("bright,300000,", "brite,300000,", 1))
    (folder / "dark3_1.npy").write_bytes(b"nothing")
    told = "\n".join(refused(folder, tmp_path))
    assert "kind is 'brite'" in told
    assert "dark3_1.npy" in told


def test_folders_that_tell_no_gain_say_why(tmp_path):
    camera = Camera1288(size=(32, 32))
    curve = camera.but(response=lambda dn: 4000 * (np.maximum(dn, 0) / 4000) ** 0.45)
    assert "a tone curve lies over the samples" in refused(curve.write(tmp_path / "c"), tmp_path)[0]
    folder = camera.write(tmp_path / "s", photons_known=False)
    table = (folder / "frames.csv").read_text()
    exchanged = table.replace("bright,", "b,").replace("dark,", "bright,").replace("b,", "dark,")
    (folder / "frames.csv").write_text(exchanged.replace(",0,", ",,"))
    assert "no brighter than dark ones" in refused(folder, tmp_path)[0]
    for path in folder.glob("bright*.npy"):
        np.save(path, np.full((32, 32), 4095, np.uint16))
    (folder / "frames.csv").write_text(table)
    assert "all of 16 bright levels are cut off" in refused(folder, tmp_path)[0]


def test_photons_may_be_nan_and_other_columns_are_named(tmp_path):
    camera = Camera1288(size=(48, 64))
    table = camera.write(tmp_path / "f", levels=8, photons_known=False) / "frames.csv"
    head, *lines = table.read_text().splitlines()
    table.write_text(
        "\n".join([head + ",irradiance", *(line.replace(",,", ",NaN,") + ",3" for line in lines)])
    )
    result = calibrate(table.parent, tmp_path)
    assert result["quantum_efficiency"]["value"] is None
    assert any("not read: irradiance" in doubt for doubt in result["doubts"])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (None, "there is no frames.csv"),
        ("file,photons_per_pixel\n", "there is no column kind, exposure_ns"),
        ("kind,exposure,file\n", "names no unit of time"),
        ("kind,exposure_ns,file\n", "there are no bright frames"),
        ("", "there is no column kind, file"),
    ],
)
def test_tables_that_lack_something(tmp_path, text, expected):
    if text is not None:
        (tmp_path / "frames.csv").write_text(text)
    assert expected in "\n".join(refused(tmp_path, tmp_path))


def test_files_that_do_not_fit_come_at_once(tmp_path):
    folder = Camera1288(size=(32, 32)).write(tmp_path / "f", levels=4)
    np.save(folder / "bright1_1.npy", np.zeros((40, 32), np.uint16))
    np.save(folder / "dark2_0.npy", np.full((32, 32), 0.5))
    (folder / "dark3_1.npy").write_bytes(b"\xff\xd8\xff")
    told = "\n".join(refused(folder, tmp_path))
    for part in ("32 x 40 pixels", "not whole", "dark3_1.npy"):
        assert part in told


def test_a_recipe_from_the_command_line(tmp_path, capsys):
    folder = Camera1288(size=(48, 64)).write(tmp_path / "f", levels=8)
    out = tmp_path / "out"
    assert main(["calibrate_camera", "--set", f"frames={folder}", "--out", str(out)]) == 0
    assert json.loads((out / "result.json").read_text())["system_gain_dn_per_e"]["ci"]
    assert main(["calibrate_camera", "--set", "frames=nowhere", "--out", str(tmp_path / "o2")]) == 2
    assert "there is no such folder" in capsys.readouterr().err


@pytest.fixture(scope="class")
def few_frames(tmp_path_factory, request):
    folder = Camera1288(size=(32, 32)).write(tmp_path_factory.mktemp("frames"), levels=6)
    request.cls.config = {"frames": str(folder)}


@pytest.mark.usefixtures("few_frames")
class TestConformance(ProcedureConformance):
    component = CalibrateCamera
    files = ("sensor.yaml", "report.html")
