"""Labels and poses of exported data, read from their files alone after each format's own definition.

`BOXES`: boxes of a class in a frame, as left, top, right, bottom by edges of pixels [px]. `POINTS`: the
(N, 3) places of the pixels of a mask, in the world of the file that was exported from [m].
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Mask = NDArray[np.bool_]
Points = NDArray[np.float64]


def _image(path: Path) -> NDArray[Any]:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image is not None, path
    return image


def _json(path: Path) -> Any:
    return json.loads(path.read_text())


def _lines(path: Path) -> list[list[str]]:
    rows = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return [row.replace(",", " ").split() for row in rows]


def _pose(turn: object, shift: object) -> NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.reshape(np.asarray(turn, float), (3, 3)), shift
    return pose


def _places(
    depth_m: NDArray[Any], mask: Mask, focal_px: float, centre_px: tuple[float, float], pose: NDArray[Any]
) -> Points:
    """Pixels of a mask in the world; the centre counts from the middle of the first pixel."""
    rows, columns = np.nonzero(mask)
    z = depth_m[rows, columns].astype(float)
    rays = np.stack([columns - centre_px[0], rows - centre_px[1], np.full(len(z), focal_px)], axis=1)
    return np.asarray(rays * (z / focal_px)[:, None] @ pose[:3, :3].T + pose[:3, 3])


def png16_mask(out: Path, index: int, kind: str) -> Mask:
    number = next(i for i, each in enumerate(_json(out / "frames.json")["objects"]) if each["class"] == kind)
    return np.asarray(_image(out / f"camera/object_id/{index:06d}.png") == number)


def _beside(out: Path, folder: str) -> Path:
    """The export of another format beside this one, for what a format has no place for."""
    return out.parent / folder


def _depth_beside(out: Path, index: int) -> NDArray[Any]:
    return np.asarray(_image(_beside(out, "png16") / f"camera/depth/{index:06d}.png") / 1000.0)


def _png16_points(out: Path, index: int, mask: Mask) -> Points:
    about = _json(out / "frames.json")
    matrix = np.array(about["cameras"]["camera"]["intrinsics"])
    pose = np.array(about["frames"][index]["world_from_camera"]["camera"])
    depth_m = _image(out / f"camera/depth/{index:06d}.png") / 1000.0
    return _places(depth_m, mask, matrix[0, 0], tuple(matrix[:2, 2]), pose)


def _tum_points(out: Path, index: int, mask: Mask) -> Points:
    walk = out / "walk_000"
    *shift, x, y, z, w = map(float, _lines(walk / "groundtruth.txt")[index][1:])
    pose = _pose(Rotation.from_quat([x, y, z, w]).as_matrix(), shift)
    depth_m = _image(walk / _lines(walk / "depth.txt")[index][1]) / 5000.0
    matrix = np.array(_json(out / "frames.json")["cameras"]["camera"]["intrinsics"])
    return _places(depth_m, mask, matrix[0, 0], tuple(matrix[:2, 2]), pose)


def _euroc_points(out: Path, index: int, mask: Mask) -> Points:
    walk = out / "walk_000/mav0"
    x, y, z, qw, qx, qy, qz = map(float, _lines(walk / "state_groundtruth_estimate0/data.csv")[index][1:8])
    camera = yaml.safe_load((walk / "cam0/sensor.yaml").read_text())
    body = _pose(Rotation.from_quat([qx, qy, qz, qw]).as_matrix(), (x, y, z))
    pose = body @ np.reshape(camera["T_BS"]["data"], (4, 4))
    focal_px, _, *centre_px = camera["intrinsics"]
    return _places(_depth_beside(out, index), mask, focal_px, tuple(centre_px), pose)


def _colmap_points(out: Path, index: int, mask: Mask) -> Points:
    focal_px, _, *corner_px = map(float, _lines(out / "sparse/0/cameras.txt")[0][4:])
    qw, qx, qy, qz, *shift = map(float, _lines(out / "sparse/0/images.txt")[index][1:8])
    pose = np.linalg.inv(_pose(Rotation.from_quat([qx, qy, qz, qw]).as_matrix(), shift))
    centre_px = (corner_px[0] - 0.5, corner_px[1] - 0.5)
    return _places(_depth_beside(out, index), mask, focal_px, centre_px, pose)


def _nerf_points(out: Path, index: int, mask: Mask) -> Points:
    data = _json(out / "transforms.json")
    frame = data["frames"][index]
    pose = np.array(frame["transform_matrix"]) @ np.diag([1.0, -1, -1, 1])  # OpenGL's camera to OpenCV's
    depth_m = _image(out / frame["depth_file_path"]) / 1000.0
    centre_px = (frame["cx"] - 0.5, frame["cy"] - 0.5)
    return _places(depth_m, mask, frame["fl_x"], centre_px, pose) + data["origin_m"]


def _kitti_points(out: Path, index: int, mask: Mask) -> Points:
    """From where the first frame was, which another format tells."""
    about = _json(out / "frames.json")["frames"][0]
    first = np.array(about["world_from_camera"]["camera"])
    pose = np.vstack([np.reshape(_lines(out / "poses.txt")[index], (3, 4)).astype(float), [0, 0, 0, 1]])
    p2 = np.reshape(_lines(out / f"calib/{index:06d}.txt")[2][1:], (3, 4)).astype(float)
    depth_m = _image(out / f"depth_2/{index:06d}.png") / 256.0
    return _places(depth_m, mask, p2[0, 0], (p2[0, 2], p2[1, 2]), first @ pose)


def _bop_points(out: Path, index: int, mask: Mask) -> Points:
    scene = out / "train/000000"
    camera = _json(scene / "scene_camera.json")[str(index)]
    matrix = np.reshape(camera["cam_K"], (3, 3))
    pose = np.linalg.inv(_pose(camera["cam_R_w2c"], np.array(camera["cam_t_w2c"]) / 1000))
    depth_m = _image(scene / f"depth/{index:06d}.png") * camera["depth_scale"] / 1000
    return _places(depth_m, mask, matrix[0, 0], tuple(matrix[:2, 2]), pose)


def _coco_boxes(out: Path, index: int, kind: str) -> list[list[float]]:
    data = _json(out / "annotations.json")
    image = next(each["id"] for each in data["images"] if each["frame"] == index)
    number = next(each["id"] for each in data["categories"] if each["name"] == kind)
    about = [a for a in data["annotations"] if (a["image_id"], a["category_id"]) == (image, number)]
    boxes = [each["bbox"] for each in about]
    return [[left, top, left + width, top + height] for left, top, width, height in boxes]


def _yolo_boxes(out: Path, index: int, kind: str) -> list[list[float]]:
    names = yaml.safe_load((out / "data.yaml").read_text())["names"]
    height_px, width_px = _image(out / f"images/camera_{index:06d}.png").shape[:2]
    rows = [[float(each) for each in line] for line in _lines(out / f"labels/camera_{index:06d}.txt")]
    return [
        [(x - w / 2) * width_px, (y - h / 2) * height_px, (x + w / 2) * width_px, (y + h / 2) * height_px]
        for number, x, y, w, h in rows
        if names[int(number)] == kind
    ]


def _kitti_boxes(out: Path, index: int, kind: str) -> list[list[float]]:
    rows = [line for line in _lines(out / f"label_2/{index:06d}.txt") if line[0] == kind]
    boxes = [[float(edge) for edge in row[4:8]] for row in rows]
    return [[left, top, right + 1, bottom + 1] for left, top, right, bottom in boxes]


def _bop_boxes(out: Path, index: int, kind: str) -> list[list[float]]:
    scene, objects = out / "train/000000", _json(out / "frames.json")["objects"]
    poses, infos = (_json(scene / f"{name}.json")[str(index)] for name in ("scene_gt", "scene_gt_info"))
    boxes = [
        info["bbox_visib"]
        for pose, info in zip(poses, infos, strict=True)
        if objects[pose["obj_id"]]["class"] == kind
    ]
    return [[left, top, left + width, top + height] for left, top, width, height in boxes]


BOXES: dict[str, Callable[[Path, int, str], list[list[float]]]] = {
    "coco": _coco_boxes,
    "yolo": _yolo_boxes,
    "kitti": _kitti_boxes,
    "bop": _bop_boxes,
}
POINTS: dict[str, Callable[[Path, int, Mask], Points]] = {
    "png16": _png16_points,
    "tum": _tum_points,
    "euroc": _euroc_points,
    "colmap": _colmap_points,
    "nerf": _nerf_points,
    "kitti": _kitti_points,
    "bop": _bop_points,
}
