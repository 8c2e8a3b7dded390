"""YOLO, NeRF, COLMAP, BOP and polygons, read back after their own definitions and held against the scene."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh
import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from tacos_export.dataset import export_dataset
from tacos_export.dataset.bop import silhouette
from tacos_export.dataset.polygons import polygons
from tacos_export.dataset.solid import Solid
from tacos_framework.errors import UserError
from tacos_framework.values import Camera, FrameBatch, Object, World
from tacos_view import RenderSetup, set_up
from tests.small_worlds import box, matte
from tests.two_boxes import monocular_recipe, plugins_with_boxes, stereo_recipe

FRAMES = 2
CUP = np.array([[2.0, -0.8, 0.6], [2.6, -0.2, 1.6]])


@pytest.fixture(scope="module")
def pair() -> RenderSetup:
    camera = {"baseline_m": 0.2, "hfov_deg": 80.0}
    return set_up(stereo_recipe(), camera, plugins=plugins_with_boxes())


@pytest.fixture(scope="module")
def frames(pair: RenderSetup) -> list[FrameBatch]:
    return list(pair.frames(FRAMES))


@pytest.fixture(scope="module")
def exported(pair: RenderSetup, tmp_path_factory: pytest.TempPathFactory) -> Any:
    made: dict[str, Path] = {}

    def export(format: str) -> Path:
        if format not in made:
            made[format] = tmp_path_factory.mktemp(format)
            assert export_dataset(pair, made[format], format, frames=FRAMES) == []
        return made[format]

    return export


def read(path: Path) -> NDArray[Any]:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image is not None, path
    return image


def on_the_cup(points_m: NDArray[np.float64]) -> bool:
    return bool((points_m > CUP[0] - 2e-3).all() and (points_m < CUP[1] + 2e-3).all())


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # pycocotools with numpy 2
@settings(max_examples=60, deadline=None)
@given(mask=arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_polygons_give_back_any_mask_with_its_holes_and_pieces(mask: NDArray[np.bool_]) -> None:
    coco = pytest.importorskip("pycocotools.mask", reason="the extra perception brings it")
    assume(mask.any())
    runs = coco.merge(coco.frPyObjects(polygons(mask), *mask.shape))
    assert np.array_equal(coco.decode(runs), mask)


def test_a_ring_is_one_polygon_and_islands_are_several() -> None:
    ring = np.ones((5, 5), bool)
    ring[2, 2] = False
    (outline,) = polygons(ring)
    x, y = np.array(outline).reshape(-1, 2).T
    area = abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))) / 2
    assert area == pytest.approx(4.5**2 - (1.5**2 - 4 * 0.5**2 / 2))  # corners of a hole are cut
    islands = np.zeros((5, 5), bool)
    islands[::4, ::4] = True
    assert len(polygons(islands)) == 4


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")  # pycocotools with numpy 2
def test_both_files_of_coco_hold_the_same_masks(exported: Any) -> None:
    coco = pytest.importorskip("pycocotools.coco", reason="the extra perception brings it").COCO
    runs, rings = (coco(str(exported("coco") / f"{name}.json")) for name in ("annotations", "polygons"))
    assert runs.anns.keys() == rings.anns.keys()
    for number, annotation in rings.anns.items():
        assert isinstance(annotation["segmentation"], list)
        assert np.array_equal(rings.annToMask(annotation), runs.annToMask(runs.anns[number]))


def test_yolo_boxes_enclose_what_is_visible(exported: Any, frames: list[FrameBatch]) -> None:
    folder = exported("yolo")
    data = yaml.safe_load((folder / "data.yaml").read_text())
    assert data["names"] == {0: "chair", 1: "cup", 2: "dog"}
    for index, frame in enumerate(frames):
        for view in frame.capture.views:
            name = f"{view.camera.name}_{index:06d}"
            height, width = read(folder / data["train"] / f"{name}.png").shape[:2]
            for line in (folder / "labels" / f"{name}.txt").read_text().splitlines():
                kind, x, y, w, h = map(float, line.split())
                mask = view.object_id[0] == {"cup": 1, "chair": 2}[data["names"][int(kind)]]
                rows, columns = np.nonzero(mask)
                edges = [(x - w / 2) * width, (x + w / 2) * width, (y - h / 2) * height, (y + h / 2) * height]
                extent = [columns.min(), columns.max() + 1, rows.min(), rows.max() + 1]
                assert edges == pytest.approx(extent, abs=1e-3)


def test_nerf_rays_of_the_cups_pixels_end_on_the_cup(exported: Any, frames: list[FrameBatch]) -> None:
    """As instant-ngp casts them: through the middle of a pixel, from its corner; y up, along -z."""
    folder = exported("nerf")
    data = json.loads((folder / "transforms.json").read_text())
    assert len(data["frames"]) == 2 * FRAMES
    for number, frame in enumerate(data["frames"]):
        view = frames[number // 2].capture.views[number % 2]
        rows, columns = np.nonzero(view.object_id[0] == 1)
        depth = read(folder / frame["depth_file_path"])[rows, columns] / 1000.0
        x = (columns + 0.5 - frame["cx"]) / frame["fl_x"]
        y = (rows + 0.5 - frame["cy"]) / frame["fl_y"]
        rays = np.stack([x, -y, -np.ones_like(x)], axis=1)
        pose = np.array(frame["transform_matrix"])
        assert on_the_cup((rays * depth[:, None]) @ pose[:3, :3].T + pose[:3, 3])
        assert np.tan(frame["camera_angle_x"] / 2) == pytest.approx(np.tan(np.radians(40)), rel=0.02)
        assert read(folder / frame["file_path"]).shape == (frame["h"], frame["w"], 3)


def test_nerf_has_intrinsics_above_the_frames_where_they_are_one(tmp_path: Path) -> None:
    recipe = monocular_recipe(effects=[{"use": "effect.lens-distortion", "k1": -0.1}])
    setup = set_up(recipe, {"focal_length_mm": 0.6}, plugins=plugins_with_boxes())
    export_dataset(setup, tmp_path / "a", "nerf", frames=1)
    data = json.loads((tmp_path / "a" / "transforms.json").read_text())
    assert (data["camera_model"], data["k1"], data["k2"], data["p1"]) == ("OPENCV", -0.1, 0, 0)
    assert data["fl_x"] == data["frames"][0]["fl_x"]
    bent = monocular_recipe(effects=[{"use": "effect.lens-distortion", "k3": -0.1}])
    setup = set_up(bent, {"focal_length_mm": 0.6}, plugins=plugins_with_boxes())
    with pytest.raises(UserError, match="has k3"):
        export_dataset(setup, tmp_path / "b", "nerf", frames=1)
    export_dataset(setup, tmp_path / "c", "colmap", frames=1)
    camera = (tmp_path / "c" / "sparse" / "0" / "cameras.txt").read_text().splitlines()[1].split()
    assert camera[1] == "FULL_OPENCV"
    assert list(map(float, camera[8:])) == [0, 0, 0, 0, -0.1, 0, 0, 0]


def rotation_of(w: float, x: float, y: float, z: float) -> NDArray[np.float64]:
    """As COLMAP's own scripts write it (qvec2rotmat)."""
    return np.array(
        [
            [1 - 2 * y**2 - 2 * z**2, 2 * x * y - 2 * w * z, 2 * z * x + 2 * w * y],
            [2 * x * y + 2 * w * z, 1 - 2 * x**2 - 2 * z**2, 2 * y * z - 2 * w * x],
            [2 * z * x - 2 * w * y, 2 * y * z + 2 * w * x, 1 - 2 * x**2 - 2 * y**2],
        ]
    )


def lines_of(path: Path) -> list[str]:
    return [line for line in path.read_text().split("\n")[:-1] if not line.startswith("#")]


def test_colmap_projects_the_cup_onto_its_pixels(exported: Any, frames: list[FrameBatch]) -> None:
    folder = exported("colmap")
    sparse = folder / "sparse" / "0"
    assert lines_of(sparse / "points3D.txt") == []
    cameras = {line.split()[0]: line.split()[1:] for line in lines_of(sparse / "cameras.txt")}
    images = lines_of(sparse / "images.txt")
    assert set(images[1::2]) == {""}  # every second line lists points, of which there are none
    assert [line.split()[0] for line in images[::2]] == ["1", "2", "3", "4"]
    for number, line in enumerate(images[::2]):
        *values, camera, name = line.split()[1:]
        model, width, height, fx, fy, cx, cy = cameras[camera]
        assert model == "PINHOLE"
        assert read(folder / "images" / name).shape == (int(height), int(width), 3)
        w, x, y, z, *shift = map(float, values)
        moved = np.mean(CUP, axis=0) @ rotation_of(w, x, y, z).T + shift
        column = float(fx) * moved[0] / moved[2] + float(cx)
        row = float(fy) * moved[1] / moved[2] + float(cy)
        view = frames[number // 2].capture.views[number % 2]
        assert view.object_id[0][int(row), int(column)] == 1
        left, top = (v - 0.5 for v in (column, row))  # the framework counts from the middle of a pixel
        at = (
            view.camera.intrinsics
            @ (np.linalg.inv(view.world_from_camera[0]) @ [*np.mean(CUP, axis=0), 1])[:3]
        )
        assert (left, top) == pytest.approx(tuple(at[:2] / at[2]), abs=1e-6)


def test_bop_models_stand_in_the_scene_where_they_are_seen(exported: Any, frames: list[FrameBatch]) -> None:
    folder = exported("bop")
    info = json.loads((folder / "models" / "models_info.json").read_text())["1"]
    model = trimesh.load(folder / "models" / "obj_000001.ply", process=False)
    assert [info[f"size_{axis}"] for axis in "xyz"] == pytest.approx([600, 600, 1000], abs=1e-2)
    assert info["diameter"] == pytest.approx(np.linalg.norm([600, 600, 1000]))
    for i in range(2):
        scene = folder / "train" / f"{i:06d}"
        cameras, poses, infos = (
            json.loads((scene / f"{name}.json").read_text())
            for name in ("scene_camera", "scene_gt", "scene_gt_info")
        )
        for index, frame in enumerate(frames):
            view, camera = frame.capture.views[i], cameras[str(index)]
            depth_mm = read(scene / "depth" / f"{index:06d}.png") * camera["depth_scale"]
            assert depth_mm / 1000 == pytest.approx(view.depth_m[0], abs=1e-3)
            for number, (pose, about) in enumerate(zip(poses[str(index)], infos[str(index)], strict=True)):
                visible = read(scene / "mask_visib" / f"{index:06d}_{number:06d}.png") > 0
                assert np.array_equal(visible, view.object_id[0] == pose["obj_id"])
                assert about["px_count_visib"] == visible.sum() <= about["px_count_all"]
                assert about["visib_fract"] == about["px_count_visib"] / about["px_count_all"]
                if pose["obj_id"] != 1:
                    continue
                turn = np.array(pose["cam_R_m2c"]).reshape(3, 3)
                points = model.vertices @ turn.T + pose["cam_t_m2c"]
                world_turn = np.array(camera["cam_R_w2c"]).reshape(3, 3)
                world_m = (points - camera["cam_t_w2c"]) @ world_turn / 1000
                assert np.stack([world_m.min(axis=0), world_m.max(axis=0)]) == pytest.approx(CUP, abs=1e-3)
                seen = points @ np.array(camera["cam_K"]).reshape(3, 3).T
                at = seen[:, :2] / seen[:, 2:]
                left, top, width, height = about["bbox_obj"]
                assert (left, top) == pytest.approx(tuple(at.min(axis=0)), abs=1.5)
                assert (left + width, top + height) == pytest.approx(tuple(at.max(axis=0)), abs=1.5)


def test_a_silhouette_shows_what_is_hidden_and_nothing_behind_the_camera() -> None:
    parts = box((2, -1, -1), (3, 1, 1), object_id=1)
    world = World("w", tuple(parts), (matte(),), (Object("r", "b"), Object("c", "c")), ("b", "c"))
    solid = Solid.of_object(world, 1)
    camera = Camera("c", 101, 101, pixel_um=10.0, focal_length_mm=0.5)
    ahead = np.array([[0.0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
    mask = silhouette(solid, ahead @ solid.world_from_model, camera)
    assert mask.sum() == pytest.approx(
        51 * 51, rel=0.03
    )  # its near side: 50 px of focal length, 2 m across at 2 m
    behind = np.diag([1.0, -1, -1, 1]) @ ahead
    assert not silhouette(solid, behind @ solid.world_from_model, camera).any()


def test_bop_refuses_distorted_images(tmp_path: Path) -> None:
    recipe = monocular_recipe(effects=[{"use": "effect.lens-distortion", "k1": -0.1}])
    setup = set_up(recipe, {"focal_length_mm": 0.6}, plugins=plugins_with_boxes())
    with pytest.raises(UserError, match="--format bop: images of camera are distorted"):
        export_dataset(setup, tmp_path / "new", "bop", frames=1)
