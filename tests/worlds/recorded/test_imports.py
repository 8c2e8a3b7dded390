"""``tacos recordings import``: other programs' layouts, and frames that cannot be trusted."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_framework.cli.tacos import main
from tacos_plugins.rigs.calibration_files import CalibratedLens
from tacos_worlds.recorded.imports.found import FoundFrame, FoundRecording
from tacos_worlds.recorded.imports.writing import write_recording
from tacos_worlds.recorded.reader import read_recording
from tacos_worlds.recorded.times import named_ms, read_times

STEP_NS = 50_000_000


def frames(folder: Path, names: list[str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(1)
    for name in names:
        cv2.imwrite(str(folder / name), rng.integers(20, 200, (48, 64)).astype(np.uint8))


def euroc(folder: Path) -> Path:
    stamps = [10**18 + i * STEP_NS for i in range(4)]
    camera = folder / "mav0" / "cam0"
    frames(camera / "data", [f"{stamp}.png" for stamp in stamps])
    lines = ["#timestamp [ns],filename", *(f"{stamp},{stamp}.png" for stamp in stamps)]
    (camera / "data.csv").write_text("\n".join(lines))
    (camera / "sensor.yaml").write_text(
        "resolution: [64, 48]\nintrinsics: [50.0, 50.0, 31.5, 23.5]\n"
        "distortion_model: radial-tangential\ndistortion_coefficients: [-0.1, 0.01, 0.0, 0.0]\n"
    )
    return folder


def tum(folder: Path) -> Path:
    frames(folder / "rgb", [f"{i}.png" for i in range(4)])
    (folder / "rgb.txt").write_text(
        "# t file\n" + "\n".join(f"{1000 + i * 0.05:.6f} rgb/{i}.png" for i in range(4))
    )
    return folder


def tum_monocular(folder: Path) -> Path:
    frames(folder / "images", [f"{i:05d}.jpg" for i in range(4)])
    lines = [f"{i:05d} {1000 + i * 0.05:.6f} 5.0" for i in range(4)]
    (folder / "times.txt").write_text("\n".join(lines))
    return folder


def dates(folder: Path) -> Path:
    frames(folder, [f"{i}.png" for i in range(4)])
    lines = [f"{i}.png,2024-05-01T12:00:00.{50 * i:03d}Z" for i in range(4)]
    (folder / "times.csv").write_text("\n".join(["file,timestamp", *lines]))
    return folder


def kitti(folder: Path) -> Path:
    frames(folder / "image_00" / "data", [f"{i:010d}.png" for i in range(4)])
    stamps = [f"2011-09-26 13:02:25.{i * 50:03d}000000" for i in range(4)]
    (folder / "image_00" / "timestamps.txt").write_text("\n".join(stamps))
    return folder


def video(folder: Path) -> Path:
    file = folder / "walk.avi"
    writer = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (64, 48))
    rng = np.random.default_rng(2)
    for _ in range(4):
        writer.write(cv2.resize(rng.integers(20, 200, (6, 8, 3)).astype(np.uint8), (64, 48)))
    writer.release()
    return file


@pytest.mark.parametrize("layout", [euroc, tum, tum_monocular, dates, kitti, video])
def test_a_recording_comes_in_with_its_times(layout, tmp_path: Path) -> None:
    (tmp_path / "source").mkdir()
    out = tmp_path / "out"
    assert (
        main(
            [
                "recordings",
                "import",
                str(layout(tmp_path / "source")),
                "--out",
                str(out),
                "--exposure-ms",
                "5",
            ]
        )
        == 0
    )
    (found,) = read_recording(out, fewest=1, response="linear").exposures.values()
    assert found.exposure_ms == 5
    np.testing.assert_allclose(np.diff(found.stamp_s), STEP_NS * 1e-9, atol=1e-6)
    assert found.codes_dn.shape == (4, 48, 64)


def test_the_calibration_of_euroc_comes_along(tmp_path: Path) -> None:
    assert (
        main(["recordings", "import", str(euroc(tmp_path / "source")), "--out", str(tmp_path / "out")]) == 0
    )
    lens = CalibratedLens.model_validate(str(tmp_path / "out" / "camera.yaml"))
    assert (lens.focal_length_px, lens.coefficients[0], lens.projection) == (50.0, -0.1, "rectilinear")


def test_frames_that_can_only_be_read_one_after_the_other_keep_their_stamps(tmp_path: Path) -> None:
    left = iter([30, 10, 20])

    def read() -> np.ndarray:
        return np.full((4, 6), next(left), np.uint8)

    frames = tuple(FoundFrame("", stamp_ns, 1.0, read) for stamp_ns in (3, 1, 2))
    write_recording(FoundRecording("a video out of order", frames), tmp_path / "out", None)
    rows = (tmp_path / "out" / "times.csv").read_text().splitlines()[1:]
    levels = {
        row.split(",")[1]: int(cv2.imread(str(tmp_path / "out" / row.split(",")[0]), 0)[0, 0]) for row in rows
    }
    assert levels == {"1": 10, "2": 20, "3": 30}


def test_exposures_of_a_table_are_kept_in_any_unit(tmp_path: Path) -> None:
    source = tmp_path / "source"
    frames(source, ["a.png", "b.png", "c.png"])
    rows = [f"{name}.png,{i * 0.1},2500" for i, name in enumerate("abc")]
    (source / "times.csv").write_text("\n".join(["filename,time_s,exposure_us", *rows]))
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "out")]) == 0
    assert set(read_recording(tmp_path / "out", fewest=1, response="linear").exposures) == {"2.5"}


def test_what_is_doubtful_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = kitti(tmp_path / "source")
    table = source / "image_00" / "timestamps.txt"
    table.write_text(table.read_text().replace("25.150", "25.900"))
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "a")]) == 0
    assert "The exposure of 4 frames is unknown: state it by --exposure-ms" in capsys.readouterr().out
    assert (
        main(["recordings", "import", str(source), "--out", str(tmp_path / "b"), "--exposure-ms", "5"]) == 0
    )
    assert "frames were dropped between them" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda s: (s / "image_00" / "timestamps.txt").unlink(), "has no table of times"),
        (lambda s: (s / "image_00" / "timestamps.txt").write_text("1.0\n2.0\n"), "has 2 times for 4 frames"),
        (lambda s: frames(s / "image_01" / "data", ["0.png"]), "holds 2 cameras: image_00, image_01"),
    ],
)
def test_folders_at_fault_are_refused(
    spoil, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = kitti(tmp_path / "source")
    spoil(source)
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err


def test_one_camera_of_a_pair_is_named_by_its_own_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = euroc(tmp_path / "source")
    shutil.copytree(source / "mav0" / "cam0", source / "mav0" / "cam1")
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "out")]) == 2
    assert f"Import {source / 'mav0' / 'cam0'} first." in capsys.readouterr().err


def test_a_bag_without_rosbags_says_what_to_install(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    (tmp_path / "walk.bag").write_bytes(b"#ROSBAG V2.0\n")
    assert main(["recordings", "import", str(tmp_path / "walk.bag"), "--out", str(tmp_path / "out")]) == 2
    assert "pip install 'tacos-framework[rosbag]'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "ms"),
    [
        ("500us_0.pgm", 0.5),
        ("left_2.5ms_07.tiff", 2.5),
        ("0_5ms_1.png", 0.5),
        ("2.5ms/0003.png", 2.5),
        ("exp_0.001s_003.tif", 1.0),
        ("3_16ms.png", 16.0),
        ("7.png", None),
    ],
)
def test_names_state_exposures_in_any_unit(name: str, ms: float | None) -> None:
    assert named_ms(name) == ms


def test_a_bracket_keeps_the_exposures_of_its_names_and_its_response(tmp_path: Path) -> None:
    source = tmp_path / "source"
    names = [f"{ms}ms_{k}.pgm" for k in range(2) for ms in (2, 4)]
    frames(source, names)
    rows = [f"{name},{1695668703.25 + 0.1 * i:.6f}" for i, name in enumerate(names)]
    (source / "times.csv").write_text("\n".join(["File,Time_s", *rows]))
    (source / "response.txt").write_text(" ".join(str(i / 255) for i in range(256)))
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "out")]) == 0
    found = read_recording(tmp_path / "out", fewest=1)
    assert set(found.exposures) == {"2", "4"}
    np.testing.assert_allclose(np.diff(found.exposures["2"].stamp_s), 0.2, atol=1e-6)
    assert found.response.light_dn[-1] == found.white_dn


@pytest.mark.parametrize(
    ("heading", "row"),
    [
        ("#timestamp [ns],filename,exposure [us]", "{ns},{name},{us}"),
        ("path;time_us;ExposureTime_us", "{name};{stamp_us};{us}"),
        ("File Name,Time (s),exposure time (ms)", "{name},{stamp_s},{ms}"),
    ],
)
def test_columns_are_found_by_any_heading_that_has_its_unit(heading: str, row: str, tmp_path: Path) -> None:
    table = tmp_path / "times.csv"
    lines = [
        row.format(
            name=f"{ms}/{k}.png",
            ns=k * STEP_NS,
            stamp_us=k * STEP_NS // 1000,
            stamp_s=k * STEP_NS * 1e-9,
            us=ms * 1000,
            ms=ms,
        )
        for k, ms in ((0, 4), (1, 8))
    ]
    table.write_text("\n".join([heading, *lines]), encoding="utf-8")
    found, faults = read_times(table)
    assert not faults
    assert [(each.file, each.stamp_ns, each.exposure_ms) for each in found] == [
        ("4/0.png", 0, 4.0),
        ("8/1.png", STEP_NS, 8.0),
    ]


def test_exposures_of_the_monocular_tum_come_along(tmp_path: Path) -> None:
    assert main(["recordings", "import", str(tum_monocular(tmp_path)), "--out", str(tmp_path / "out")]) == 0
    assert set(read_recording(tmp_path / "out", fewest=1, response="linear").exposures) == {"5"}


def test_a_number_in_a_column_of_dates_is_named(tmp_path: Path) -> None:
    (tmp_path / "times.csv").write_text("file,time\na.png,2024-05-01T12:00:00\nb.png,1.5\n")
    found, faults = read_times(tmp_path / "times.csv")
    assert [each.stamp_ns for each in found] == [1_714_564_800 * 10**9]
    assert [(fault.what, fault.expected[:6]) for fault in faults] == [("has time '1.5'", "a date")]


def test_a_column_without_its_unit_is_named(tmp_path: Path) -> None:
    (tmp_path / "times.csv").write_text("filename,timestamp,exposure_time\na.png,1.5,0.004\n")
    found, faults = read_times(tmp_path / "times.csv")
    assert not found
    assert [fault.what for fault in faults] == [
        "the column timestamp states no unit",
        "the column exposure_time states no unit",
    ]


def test_exposures_may_be_fractions_of_seconds_and_faults_name_their_cell(tmp_path: Path) -> None:
    table = tmp_path / "times.csv"
    table.write_text("file,taken_ns,exposure_s\na.png,1,1/125\nb.png,2,1/0\nc.png,x,1/60\n")
    found, faults = read_times(table)
    assert [each.exposure_ms for each in found] == [8.0]
    assert [fault.what for fault in faults] == ["has exposure_s '1/0'", "has taken_ns 'x'"]
    table.write_text("file,taken_ns,exposure_ms\na.png,1,1/125\n")  # of a second, or of a millisecond?
    assert [fault.what for fault in read_times(table)[1]] == ["has exposure_ms '1/125'"]
