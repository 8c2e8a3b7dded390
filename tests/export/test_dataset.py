"""Data sets, read back by the readers users have, and held against what was rendered."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tacos_export.conventions import EPOCH_S, stamp_ns, stamp_s
from tacos_export.dataset import FORMATS, export_dataset
from tacos_export.dataset.frame import Dataset
from tacos_export.dataset.raster import Png16Writer
from tacos_framework.camera.colour import display_image
from tacos_framework.cli import tacos_main
from tacos_framework.errors import UserError
from tacos_framework.values import Capture, FrameBatch
from tacos_view import RenderSetup, set_up
from tests.two_boxes import monocular_recipe, plugins_with_boxes, stereo_recipe

FRAMES = 3


@pytest.fixture(scope="module")
def pair() -> RenderSetup:
    camera = {"baseline_m": 0.2, "hfov_deg": 80.0}
    return set_up(stereo_recipe(), camera, plugins=plugins_with_boxes())


@pytest.fixture(scope="module")
def frames(pair: RenderSetup) -> list[FrameBatch]:
    return list(pair.frames(FRAMES))


@pytest.fixture
def exported(pair: RenderSetup, tmp_path: Path) -> Any:
    def export(format: str, **options: Any) -> Path:
        assert export_dataset(pair, tmp_path / format, format, frames=FRAMES, **options) == []
        return tmp_path / format

    return export


def read(path: Path) -> NDArray[Any]:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image is not None, path
    return image


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # pycocotools with numpy 2
def test_coco_is_read_by_pycocotools(exported: Any, frames: list[FrameBatch]) -> None:
    coco = pytest.importorskip("pycocotools.coco", reason="the extra perception brings it").COCO
    folder = exported("coco")
    data = coco(str(folder / "annotations.json"))
    assert [c["name"] for c in data.loadCats(data.getCatIds())] == ["chair", "cup", "dog"]
    assert len(data.getImgIds()) == 2 * FRAMES
    for image in data.loadImgs(data.getImgIds()):
        view = frames[image["frame"]].capture.views[["left", "right"].index(image["camera"])]
        assert read(folder / "images" / image["file_name"]).shape == (image["height"], image["width"], 3)
        annotations = data.loadAnns(data.getAnnIds(imgIds=image["id"]))
        assert {a["object_id"] for a in annotations} == {1, 2}
        for annotation in annotations:
            mask = view.object_id[0] == annotation["object_id"]
            assert np.array_equal(data.annToMask(annotation), mask)
            assert annotation["area"] == mask.sum()
            x, y, width, height = annotation["bbox"]
            assert mask[y : y + height, x : x + width].sum() == mask.sum()
            assert mask[y].any()
            assert mask[:, x + width - 1].any()


def test_kitti_depth_disparity_and_calibration_agree(exported: Any, frames: list[FrameBatch]) -> None:
    folder = exported("kitti")
    calibration = dict(
        line.split(": ") for line in (folder / "calib" / "000001.txt").read_text().splitlines()
    )
    p2, p3 = (np.array(calibration[key].split(), float).reshape(3, 4) for key in ("P2", "P3"))
    assert p3[0, 3] == pytest.approx(-0.2 * p2[0, 0])
    depth = read(folder / "depth_2" / "000001.png") / 256.0
    disparity = read(folder / "disp_2" / "000001.png") / 256.0
    truth = frames[1].capture.views[0].depth_m[0]
    assert np.abs(depth - truth).max() <= 0.5 / 256 + 1e-6
    assert np.abs(disparity - p2[0, 0] * 0.2 / truth).max() <= 0.5 / 256 + 1e-6
    labels = [line.split() for line in (folder / "label_2" / "000001.txt").read_text().splitlines()]
    assert [label[0] for label in labels] == ["cup", "chair"]
    assert all(len(label) == 15 for label in labels)
    left, top, right, bottom = (int(float(each)) for each in labels[0][4:8])
    mask = frames[1].capture.views[0].object_id[0] == 1
    assert mask[top : bottom + 1, left : right + 1].sum() == mask.sum()


def test_kitti_poses_are_read_by_evo(exported: Any, frames: list[FrameBatch]) -> None:
    evo = pytest.importorskip("evo.tools.file_interface", reason="the extra crosscheck brings evo")
    folder = exported("kitti")
    poses = evo.read_kitti_poses_file(folder / "poses.txt").poses_se3
    first, last = (frames[i].capture.views[0].world_from_camera[0] for i in (0, -1))
    assert poses[0] == pytest.approx(np.eye(4))
    assert poses[-1] == pytest.approx(np.linalg.inv(first) @ last, abs=1e-9)


def test_tum_path_is_read_by_evo(exported: Any, frames: list[FrameBatch]) -> None:
    evo = pytest.importorskip("evo.tools.file_interface", reason="the extra crosscheck brings evo")
    path = evo.read_tum_trajectory_file(exported("tum") / "walk_000" / "groundtruth.txt")
    assert (path.timestamps - EPOCH_S).tolist() == pytest.approx([0.25, 0.5, 0.75], abs=1e-6)
    truth = np.stack([frame.capture.views[0].world_from_camera[0] for frame in frames])
    assert np.stack(path.poses_se3) == pytest.approx(truth, abs=1e-7)


def test_euroc_path_is_read_by_evo_and_moves_as_it_says(exported: Any, frames: list[FrameBatch]) -> None:
    evo = pytest.importorskip("evo.tools.file_interface", reason="the extra crosscheck brings evo")
    folder = exported("euroc") / "walk_000" / "mav0"
    table = folder / "state_groundtruth_estimate0" / "data.csv"
    path = evo.read_euroc_csv_trajectory(table)
    assert (path.timestamps - EPOCH_S).tolist() == pytest.approx([0.25, 0.5, 0.75], abs=1e-6)
    for i, camera in enumerate(("cam0", "cam1")):
        sensor = yaml.safe_load((folder / camera / "sensor.yaml").read_text())
        body_from_camera = np.array(sensor["T_BS"]["data"]).reshape(4, 4)
        for frame, body in zip(frames, path.poses_se3, strict=True):
            truth = frame.capture.views[i].world_from_camera[0]
            assert body @ body_from_camera == pytest.approx(truth, abs=1e-7)
        assert sensor["rate_hz"] == 4.0
        assert read(folder / camera / "data" / "1400000000500000000.png").shape == (48, 64, 3)
    rows = np.loadtxt(table, delimiter=",")
    steps = np.diff(rows[:, 1:4], axis=0) / 0.25
    assert rows[:2, 8:11] == pytest.approx(steps, abs=1e-6)  # the agent of this scene moves steadily


def test_the_formats_own_rules_hold_without_their_readers(exported: Any, frames: list[FrameBatch]) -> None:
    """TUM in plain numpy: rotation from the quaternion by its definition, depth by its factor."""
    folder = exported("tum") / "walk_000"
    rows = np.loadtxt(folder / "groundtruth.txt")
    for row, frame in zip(rows, frames, strict=True):
        pose = frame.capture.views[0].world_from_camera[0]
        x, y, z, w = row[4:]
        rotation = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        assert row[1:4] == pytest.approx(pose[:3, 3], abs=1e-8)
        assert np.array(rotation) == pytest.approx(pose[:3, :3], abs=1e-7)
    stamp, name = (folder / "depth.txt").read_text().splitlines()[1].split()
    assert read(folder / name) / 5000.0 == pytest.approx(frames[0].capture.views[0].depth_m[0], abs=1e-4)
    assert float(stamp) == rows[0, 0]


def test_16_bit_png_keeps_what_was_rendered(exported: Any, frames: list[FrameBatch]) -> None:
    folder = exported("png16")
    image = read(folder / "right" / "image" / "000002.png")
    assert image.dtype == np.uint16
    assert np.array_equal(image[..., ::-1], frames[2].images[1][0] * np.uint16(257))
    depth = read(folder / "right" / "depth" / "000002.png") / 1000.0
    assert depth == pytest.approx(frames[2].capture.views[1].depth_m[0], abs=5.1e-4)
    ids = read(folder / "right" / "object_id" / "000002.png")
    assert np.array_equal(ids, frames[2].capture.views[1].object_id[0])


def with_objects(frame: FrameBatch, count: int) -> FrameBatch:
    """The frame in a world of so many objects, its first pixel showing the last of them."""
    view, *others = frame.capture.views
    ids = view.object_id.copy()
    ids[0, 0, 0] = count - 1
    world = frame.episode.world
    many = replace(world, objects=world.objects + (world.objects[1],) * (count - len(world.objects)))
    views = (replace(view, object_id=ids), *others)
    return replace(frame, capture=Capture(replace(frame.episode, world=many), views))


def test_more_objects_than_16_bits_number_are_refused_not_numbered_anew(
    frames: list[FrameBatch], pair: RenderSetup, tmp_path: Path
) -> None:
    writer = Png16Writer(Dataset(tmp_path, pair.rig, {}, "srgb"))
    writer.add(0, with_objects(frames[0], 65536))
    assert read(tmp_path / "left" / "object_id" / "000000.png")[0, 0] == 65535
    with pytest.raises(UserError) as refused:
        writer.add(1, with_objects(frames[0], 65537))
    said = str(refused.value)
    assert "--format png16: the scene has 65537 objects" in said
    assert "65536 at most" in said
    assert "--format exr" in said
    assert not (tmp_path / "left" / "image" / "000001.png").exists()


def test_exr_holds_light_and_depth_as_they_are(exported: Any, frames: list[FrameBatch]) -> None:
    openexr = pytest.importorskip("OpenEXR", reason="the extra export brings it")
    folder = exported("exr")
    with openexr.File(str(folder / "left" / "000001.exr"), separate_channels=True) as file:
        channels = file.channels()
        view = frames[1].capture.views[0]
        assert np.array_equal(channels["Z"].pixels, view.depth_m[0])
        assert np.array_equal(channels["G"].pixels, view.luminance_cd_m2[0][..., 1])
        assert np.array_equal(channels["id"].pixels, view.object_id[0])


def test_depth_of_one_pose_falls_onto_the_depth_of_another(exported: Any) -> None:
    """The conventions hold together: files alone take pixels of frame 0 into frame 2 of the other camera."""
    folder = exported("png16")
    about = json.loads((folder / "frames.json").read_text())
    k = {name: np.array(camera["intrinsics"]) for name, camera in about["cameras"].items()}
    poses = [
        {name: np.array(pose) for name, pose in frame["world_from_camera"].items()}
        for frame in about["frames"]
    ]
    depth = read(folder / "left" / "depth" / "000000.png") / 1000.0
    y, x = np.mgrid[: depth.shape[0], : depth.shape[1]]
    rays = np.stack([x, y, np.ones_like(x)], axis=-1) @ np.linalg.inv(k["left"]).T
    points = np.concatenate([rays * depth[..., None], np.ones((*depth.shape, 1))], axis=-1)
    other_from_first = np.linalg.inv(poses[2]["right"]) @ poses[0]["left"]
    moved = (points @ other_from_first.T)[..., :3]
    pixels = moved @ k["right"].T
    column, row = (np.rint(pixels[..., i] / pixels[..., 2]).astype(int) for i in (0, 1))
    inside = (column >= 0) & (column < 64) & (row >= 0) & (row < 48)
    there = read(folder / "right" / "depth" / "000002.png")[row[inside], column[inside]] / 1000.0
    difference = np.abs(there - moved[..., 2][inside])
    assert inside.mean() > 0.7
    assert np.median(difference) < 0.02
    assert (difference < 0.1).mean() > 0.85  # the rest is hidden from one of the two, or at an edge


def test_objects_are_found_at_the_same_place_from_two_poses(exported: Any) -> None:
    """Ids follow the same conventions as depth: the cup of either frame lies on the cup's box."""
    folder = exported("png16")
    about = json.loads((folder / "frames.json").read_text())
    cup = next(i for i, thing in enumerate(about["objects"]) if thing["class"] == "cup")
    k = np.array(about["cameras"]["left"]["intrinsics"])
    for i, frame in enumerate(about["frames"]):
        depth = read(folder / "left" / "depth" / f"{i:06d}.png") / 1000.0
        y, x = np.nonzero(read(folder / "left" / "object_id" / f"{i:06d}.png") == cup)
        points = np.linalg.inv(k) @ np.stack([x, y, np.ones_like(x)]) * depth[y, x]
        pose = np.array(frame["world_from_camera"]["left"])
        places = (pose[:3, :3] @ points).T + pose[:3, 3]
        assert (places > np.array([2.0, -0.8, 0.6]) - 2e-3).all()
        assert (places < np.array([2.6, -0.2, 1.6]) + 2e-3).all()


@pytest.mark.parametrize("encoding", ["srgb", "camera"])
def test_images_are_photographs_or_the_cameras_numbers(
    exported: Any, frames: list[FrameBatch], encoding: str
) -> None:
    folder = exported("coco", encoding=encoding)
    file = read(folder / "images" / "left_000000.png")[..., ::-1]
    own = frames[0].images[0][0]
    assert np.array_equal(file, display_image(own, 0, 255) if encoding == "srgb" else own)
    assert json.loads((folder / "frames.json").read_text())["encoding"] == encoding


def test_images_of_16_bits_are_said_to_be_linear(exported: Any, pair: RenderSetup, tmp_path: Path) -> None:
    """Whoever took them for sRGB, as `frames.json` said, would take the curve off once too often."""
    assert json.loads((exported("png16") / "frames.json").read_text())["encoding"] == "linear"
    with pytest.raises(UserError, match="--encoding srgb: images of png16 have 16 bits"):
        export_dataset(pair, tmp_path / "new", "png16", frames=1, encoding="srgb")
    assert not (tmp_path / "new").exists()


def test_a_tone_curve_is_not_encoded_twice(tmp_path: Path) -> None:
    recipe = monocular_recipe(effects=[{"use": "effect.tone-curve", "gamma": 2.2}])
    setup = set_up(recipe, {"focal_length_mm": 0.6}, plugins=plugins_with_boxes())
    export_dataset(setup, tmp_path, "coco", frames=1)
    assert json.loads((tmp_path / "frames.json").read_text())["encoding"] == "camera"


def test_distortion_stands_in_the_files(tmp_path: Path) -> None:
    recipe = monocular_recipe(effects=[{"use": "effect.lens-distortion", "k1": -0.1}])
    setup = set_up(recipe, {"focal_length_mm": 0.6}, plugins=plugins_with_boxes())
    export_dataset(setup, tmp_path / "a", "euroc", frames=1)
    about = json.loads((tmp_path / "a" / "frames.json").read_text())["cameras"]["camera"]
    assert (about["lens"], about["distortion"]) == ("brown", [-0.1, 0, 0, 0, 0])
    with pytest.raises(UserError, match="rectified images"):
        export_dataset(setup, tmp_path / "b", "kitti", frames=1)


def test_what_is_wrong_is_said(pair: RenderSetup, tmp_path: Path) -> None:
    (tmp_path / "something").touch()
    with pytest.raises(UserError, match="not empty"):
        export_dataset(pair, tmp_path, "coco", frames=1)
    with pytest.raises(UserError, match="Did you mean 'coco'"):
        export_dataset(pair, tmp_path / "new", "cocoo", frames=1)


def test_a_trip_that_is_over_before_is_counted_as_long_as_it_was(
    frames: list[FrameBatch],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """As of a recorded path, which has as many frames as it lasts."""
    monkeypatch.setattr(RenderSetup, "frames", lambda *_, **__: iter(frames[:2]))
    command = ["export", "dataset", "stereo_quick", "--format", "tum", "--frames", "5"]
    assert tacos_main([*command, "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("2 frames of ")
    assert "note: the trip ends after 2 of 5 frames\n" in said


def test_the_command_offers_all_formats() -> None:
    from tacos_export import commands

    assert tuple(FORMATS) == commands.FORMATS


@given(st.lists(st.floats(0, 1e6), min_size=2, max_size=20))
def test_names_by_stamps_are_of_one_length_and_sort_by_time(times_s: list[float]) -> None:
    rising = sorted(times_s)
    for name in (lambda time_s: str(stamp_ns(time_s)), stamp_s):
        names = [name(time_s) for time_s in rising]
        assert names == sorted(names)
        assert len(set(map(len, names))) == 1
        assert int(names[0].replace(".", "")[:-9]) > 0


def test_overexposed_frames_are_told_and_counted(tmp_path: Path) -> None:
    bright = {"illumination_lux": 1e5, "exposure_ms": 50.0}
    setup = set_up(monocular_recipe(scenario=bright), {"focal_length_mm": 0.6}, plugins=plugins_with_boxes())
    (note,) = export_dataset(setup, tmp_path, "png16", frames=1)
    assert "of pixels are saturated: shorten exposure_ms" in note
    about = json.loads((tmp_path / "frames.json").read_text())["cameras"]["camera"]["exposed"]
    image = read(tmp_path / "camera" / "image" / "000000.png")
    assert about["saturated"] == (image == 65535).any(axis=-1).mean() > 0.5
