"""Lenses from calibration files: OpenCV's YAML and XML, ROS's camera_info, Kalibr's and EuRoC's YAML."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any
from xml.etree import ElementTree

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from tacos_framework import Lens, Projection, Settings, UserError, read_yaml, setting
from tacos_framework.files import read_text
from tacos_plugins.rigs.optics import LISTED, Coefficients

MOST_UNEVEN = 0.02
"""Largest relative difference of the focal lengths across and down; pixels are square here."""

_MODELS: Mapping[str, Projection] = {
    "plumb_bob": "rectilinear",
    "rational_polynomial": "rectilinear",
    "radtan": "rectilinear",
    "radial-tangential": "rectilinear",
    "none": "rectilinear",
    "equidistant": "kannala-brandt",
    "fisheye": "kannala-brandt",
}

_OTHER_NAMES = {
    "width": "image_width",
    "height": "image_height",
    "k": "camera_matrix",
    "d": "distortion_coefficients",
}
"""Of messages of ROS, as `topic echo` writes them, in small letters."""
_REMEDY = (
    "Give a file of OpenCV (YAML, JSON or XML), ROS (camera_info), Kalibr (camchain.yaml) or EuRoC "
    "(sensor.yaml), or its numbers."
)


class CalibratedLens(Settings):
    """The lens of a camera that was calibrated: a file of OpenCV, ROS or Kalibr, or its numbers."""

    title: str = setting("the calibration", help="Its name in messages.")
    width_px: int = setting(help="Width of the images it was calibrated with.", unit="px", ge=1)
    height_px: int = setting(help="Height of those images.", unit="px", ge=1)
    focal_length_px: float = setting(help="Focal length on the axis.", unit="px", gt=0)
    centre_px: Annotated[tuple[float, float], LISTED] = setting(help="Principal point (x, y).", unit="px")
    projection: Projection = setting(help="Its projection.")
    coefficients: Coefficients = setting((), help="In OpenCV's order.")
    baseline_m: float | None = setting(
        None, help="Distance to the second camera of its chain, for a note.", unit="m", ge=0
    )

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, given: Any) -> Any:
        if not isinstance(given, str):
            return given
        try:
            return read_calibration(Path(given))
        except UserError as error:
            found = "; ".join(f"{fault.where}: {fault.what}" for fault in error.faults)
        except (LookupError, TypeError, ValueError) as error:
            found = f"{given}: {error}"
        raise PydanticCustomError(
            "calibration_file",
            "a calibration by OpenCV, ROS or Kalibr ({found})",
            {"found": found, "remedy": _REMEDY},
        )

    @property
    def lens(self) -> Lens:
        """Its projection; the image circle is nobody's claim."""
        return Lens(self.projection, self.coefficients)


def read_calibration(path: Path) -> dict[str, Any]:
    """The settings of a `CalibratedLens` in a file; of a camera chain the first camera.

    Raises `UserError` when the file cannot be read, or is no YAML. Raises `ValueError` when it is XML that is
    spoilt, or something in it is missing, or not a lens that is known here.
    """
    text = re.sub(r"\A%YAML[^\n]*\n", "", read_text(path, where=str(path)))  # OpenCV's directive is not YAML
    if text.lstrip().startswith("<"):
        data: Any = _of_xml(text)
    else:
        data = read_yaml(text.replace("!!opencv-matrix", ""), str(path), aliases=True).data
    camera = data.get("cam0", data) if isinstance(data, dict) else data
    if not isinstance(camera, dict):
        raise ValueError("it has no names of values")
    by_kalibr = camera is not data or "intrinsics" in camera
    found = _kalibr_or_euroc(camera) if by_kalibr else _opencv_or_ros(camera)
    if by_kalibr:
        found["baseline_m"] = _baseline_m(data.get("cam1"))
    across, down = found.pop("focal_lengths_px")
    if abs(across / down - 1) > MOST_UNEVEN:
        raise ValueError(f"focal lengths {across:g} and {down:g} px, where pixels are square")
    return {"title": path.name, **found, "focal_length_px": math.sqrt(across * down)}


def _of_xml(text: str) -> dict[str, Any]:
    """The entries of a file that `cv2.FileStorage` wrote as XML."""
    if "<!DOCTYPE" in text:  # entities may grow without bound
        raise ValueError("its XML has a DOCTYPE, where OpenCV writes none")
    try:
        return {each.tag: _of_element(each) for each in ElementTree.fromstring(text)}
    except ElementTree.ParseError as error:
        raise ValueError(f"this is not valid XML: {error}") from error


def _of_element(element: ElementTree.Element) -> Any:
    if (data := element.findtext("data")) is not None:
        return {"data": [float(word) for word in data.split()]}
    text = (element.text or "").strip()
    return int(text) if text.isdecimal() else text


def _kalibr_or_euroc(camera: Mapping[str, Any]) -> dict[str, Any]:
    if "distortion_coefficients" in camera:  # of EuRoC
        camera = {"distortion_coeffs": camera["distortion_coefficients"], **camera}
    _require(camera, "intrinsics", "resolution", "distortion_model", "distortion_coeffs")
    if camera.get("camera_model", "pinhole") != "pinhole":
        raise ValueError(f"camera_model {camera['camera_model']!r}, where pinhole is known")
    across, down, x, y = camera["intrinsics"]
    width, height = camera["resolution"]
    return {
        "width_px": width,
        "height_px": height,
        "focal_lengths_px": (across, down),
        "centre_px": (x, y),
        **_lens(camera["distortion_model"], camera["distortion_coeffs"]),
    }


def _baseline_m(second: Any) -> float | None:
    """Distance of the second camera of a chain from the first; None where there is none [m]."""
    if not isinstance(second, dict) or "T_cn_cnm1" not in second:
        return None
    return math.hypot(*(row[3] for row in second["T_cn_cnm1"][:3]))


def _opencv_or_ros(given: Mapping[str, Any]) -> dict[str, Any]:
    small = {key.lower(): value for key, value in given.items()}  # older OpenCV: Camera_Matrix
    data = {**{name: small[other] for other, name in _OTHER_NAMES.items() if other in small}, **small}
    _require(data, "image_width", "image_height", "camera_matrix", "distortion_coefficients")
    across, _, x, _, down, y, *_ = _numbers(data["camera_matrix"])
    model = data.get("distortion_model") or ("fisheye" if data.get("fisheye_model") else "plumb_bob")
    return {
        "width_px": data["image_width"],
        "height_px": data["image_height"],
        "focal_lengths_px": (across, down),
        "centre_px": (x, y),
        **_lens(model, _numbers(data["distortion_coefficients"])),
    }


def _numbers(matrix: Any) -> Sequence[float]:
    """Of a matrix with its size, or of a list."""
    numbers: Sequence[float] = matrix["data"] if isinstance(matrix, dict) else matrix
    return numbers


def _lens(model: str, coefficients: Sequence[float]) -> dict[str, Any]:
    if (projection := _MODELS.get(model)) is None:
        raise ValueError(f"distortion model {model!r}, where {', '.join(_MODELS)} are known")
    most = 4 if projection == "kannala-brandt" else 5
    if any(coefficients[most:]):
        raise ValueError(
            f"{len(coefficients)} coefficients of distortion model {model!r}, where {most} are known"
        )
    return {"projection": projection, "coefficients": tuple(coefficients[:most])}


def _require(data: Mapping[str, Any], *keys: str) -> None:
    if missing := [key for key in keys if key not in data]:
        raise ValueError(f"it lacks {', '.join(missing)}")
