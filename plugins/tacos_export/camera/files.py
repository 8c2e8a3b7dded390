"""Writes the cameras of a rig for OpenCV, ROS and Kalibr, and their noise."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tacos_export.camera.description import CameraDescription, second_from_first
from tacos_framework import to_yaml
from tacos_framework.files import made_folder

_KALIBR_MODEL = {"brown": "radtan", "fisheye": "equidistant"}
_ROS_MODEL = {"brown": "plumb_bob", "fisheye": "equidistant"}


def write_camera_files(out: Path, cameras: Sequence[CameraDescription]) -> tuple[list[Path], list[str]]:
    """One set of files for a rig.

    ======================  ===============================================================================
    ``NAME_opencv.yaml``    `cv2.FileStorage`: camera_matrix, distortion_coefficients, as `calibrateCamera`
    ``rig_opencv.yaml``     of each further camera R and T from the first, as `stereoCalibrate`
    ``NAME_ros.yaml``       ROS ``camera_info``, as camera_calibration writes it
    ``camchain.yaml``       Kalibr; left out where its lens models cannot say the distortion
    ``NAME_noise.yaml``     system gain, dark noise, saturation capacity in the units of EMVA 1288
    ======================  ===============================================================================

    - `out`: the folder; made where it is not there.

    Returns: the files, and in a sentence each what they do not say.
    """
    made_folder(out)
    written = []
    for each in cameras:
        name = each.camera.name
        written.append(_write_opencv(out / f"{name}_opencv.yaml", each))
        written.append(_write(out / f"{name}_ros.yaml", ros_camera_info(each, cameras[0])))
        written.append(_write(out / f"{name}_noise.yaml", each.noise.as_data()))
    if len(cameras) > 1:
        written.append(_write_opencv_rig(out / "rig_opencv.yaml", cameras))
    limitations = [f"{each.camera.name}: {said}" for each in cameras for said in each.limitations]
    unsaid = [each.camera.name for each in cameras if each.lens == "brown" and each.distortion[4]]
    if unsaid:
        limitations.append(f"{', '.join(unsaid)}: Kalibr's radtan has no k3, so there is no camchain.yaml")
    else:
        written.append(_write(out / "camchain.yaml", kalibr_camchain(cameras)))
    return written, limitations


def ros_camera_info(described: CameraDescription, first: CameraDescription) -> dict[str, Any]:
    """The YAML that ROS's camera_info_manager loads; P has the baseline of a second, parallel camera."""
    camera = described.camera
    projection = np.hstack([camera.intrinsics, np.zeros((3, 1))])
    baseline = second_from_first(first.camera, camera)
    if described is not first and np.allclose(baseline[:3, :3], np.eye(3), atol=1e-9):
        projection[:, 3] = camera.intrinsics @ baseline[:3, 3]
    return {
        "image_width": camera.width_px,
        "image_height": camera.height_px,
        "camera_name": camera.name,
        "camera_matrix": _matrix(camera.intrinsics),
        "distortion_model": _ROS_MODEL[described.lens],
        "distortion_coefficients": _matrix(np.array([described.distortion])),
        "rectification_matrix": _matrix(np.eye(3)),
        "projection_matrix": _matrix(projection),
    }


def kalibr_camchain(cameras: Sequence[CameraDescription]) -> dict[str, Any]:
    """Kalibr's camera chain; radtan has (k1, k2, p1, p2), equidistant (k1, k2, k3, k4)."""
    chain: dict[str, Any] = {}
    for i, each in enumerate(cameras):
        camera = each.camera
        f = camera.focal_length_px
        chain[f"cam{i}"] = {
            "camera_model": "pinhole",
            "intrinsics": [f, f, *camera.centre_px],
            "distortion_model": _KALIBR_MODEL[each.lens],
            "distortion_coeffs": list(each.distortion[:4]),
            "resolution": [camera.width_px, camera.height_px],
            "rostopic": f"/{camera.name}/image_raw",
            "cam_overlaps": [k for k in range(len(cameras)) if k != i],
        }
        if i:
            chain[f"cam{i}"]["T_cn_cnm1"] = second_from_first(cameras[i - 1].camera, camera).tolist()
    return chain


def _write_opencv(path: Path, described: CameraDescription) -> Path:
    import cv2

    camera = described.camera
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", camera.width_px)
    storage.write("image_height", camera.height_px)
    storage.write("camera_matrix", camera.intrinsics)
    storage.write("fisheye_model", int(described.lens == "fisheye"))
    storage.write("distortion_coefficients", np.array([described.distortion]))
    storage.write("body_from_camera", np.asarray(camera.agent_from_camera))
    storage.release()
    return path


def _write_opencv_rig(path: Path, cameras: Sequence[CameraDescription]) -> Path:
    import cv2

    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for each in cameras[1:]:
        pose = second_from_first(cameras[0].camera, each.camera)
        storage.write(f"R_{each.camera.name}", pose[:3, :3].copy())
        storage.write(f"T_{each.camera.name}", pose[:3, 3:].copy())
    storage.release()
    return path


def _matrix(values: np.ndarray) -> dict[str, Any]:
    rows, columns = values.shape
    return {"rows": rows, "cols": columns, "data": [float(each) for each in values.ravel()]}


def _write(path: Path, data: dict[str, Any]) -> Path:
    path.write_text(to_yaml(data, flow_style=None), encoding="utf-8")
    return path
