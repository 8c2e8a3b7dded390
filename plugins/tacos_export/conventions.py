"""The conventions of everything that is exported, and the functions that carry them out.

Axes
    A camera looks along z, x is right and y down in the image (OpenCV, ROS optical frames, KITTI, TUM). The
    body is the agent: x forward, y left, z up (ROS base frames). The world is right-handed with z up. All
    lengths are in metres. Other programs differ: the camera of NeRF has y up and looks along -z (OpenGL),
    COLMAP and BOP have ``camera_from_world``, and BOP millimetres.
Poses
    ``a_from_b`` takes homogeneous points of frame b to frame a; a camera's pose is ``world_from_camera``,
    in the middle of the exposure. Quaternions are unit length with w >= 0; files say in which order.
Pixels
    Row 0 is the top row, pixel (0, 0) has its *centre* at (0, 0), and an image spans -0.5 .. width - 0.5, as
    in OpenCV. So the principal point of a centred lens is ((width - 1) / 2, (height - 1) / 2). Boxes of COCO
    are (left, top, width, height) with edges of pixels, those of KITTI (left, top, right, bottom) with the
    first and last pixel. COLMAP and NeRF count principal points from the image's corner: half a pixel more.
Depth
    The distance along the optical axis (z), not along the ray, and ``point = depth * K^-1 (x, y, 1)``; of
    fisheyes, whose axis measures nothing to the side, along the ray (``depth_along`` in ``frames.json``).
    Where nothing is, or beyond what 16 bits hold, 0 in integer files and infinity in EXR.
Stamps
    Episodes begin at 1.4e9 s after 1970, so that all stamps have as many digits and names sort by time.
Images
    Linear digital numbers, proportional to light above the black level; ``srgb`` encodes them for eyes, and
    for programs that expect photographs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, World

EPOCH_S = 1_400_000_000
"""When episodes begin, in seconds since 1970: stamps of equal length, as recordings have them [s]."""

UNKNOWN_DEPTH = 0
"""What integer depth files hold where nothing is, or what does not fit."""


def depth_codes(depth_m: NDArray[np.floating], codes_per_m: float) -> NDArray[np.uint16]:
    """Depth as 16-bit integers.

    - `depth_m`: depth as `View.depth_m` has it, infinite where nothing is [m].
    - `codes_per_m`: 1000 for millimetres, 256 for KITTI, 5000 for TUM [1/m].

    >>> depth_codes(np.array([1.5, np.inf, 80.0]), 1000).tolist()
    [1500, 0, 0]
    """
    codes = np.rint(np.nan_to_num(np.asarray(depth_m, np.float64) * codes_per_m, posinf=0.0))
    return np.where((codes > 0) & (codes < 2**16), codes, UNKNOWN_DEPTH).astype(np.uint16)


def quaternion_xyzw(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation of a (4, 4) pose as a unit quaternion (x, y, z, w), w >= 0.

    >>> quaternion_xyzw(np.eye(4)).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(pose[:3, :3]).as_quat(canonical=True))


def at_full_resolution(camera: Camera) -> Camera:
    """The camera with all of its pixels; the simulation may average blocks of them.

    A point at x of the simulated image lies at ``(x + 0.5) * b - 0.5`` of the whole one, with b its
    `Camera.simulated_binning`. Photosites that the camera itself bins stay one pixel.

    >>> camera = Camera("c", 320, 240, pixel_um=2.0, focal_length_mm=4.0, binning=2)
    >>> full = at_full_resolution(camera)
    >>> full.width_px, full.focal_length_px / camera.focal_length_px, full.centre_px
    (640, 2.0, (319.5, 239.5))
    """
    factor = camera.simulated_binning
    x, y = ((at + 0.5) * factor - 0.5 for at in camera.centre_px)
    return replace(
        camera,
        width_px=round(camera.width_px * factor),
        height_px=round(camera.height_px * factor),
        binning=float(camera.sensor_binning),
        principal_point_px=(x, y),
    )


def stamp_ns(time_s: float) -> int:
    """A time of an episode as a stamp in whole nanoseconds, as ROS and EuRoC count [s to ns].

    >>> stamp_ns(0.05)
    1400000000050000000
    """
    return EPOCH_S * 10**9 + round(time_s * 1e9)


def stamp_s(time_s: float) -> str:
    """The same stamp in seconds, with six decimals.

    >>> stamp_s(10.05)
    '1400000010.050000'
    """
    microseconds = EPOCH_S * 10**6 + round(time_s * 1e6)
    return f"{microseconds // 10**6}.{microseconds % 10**6:06d}"


def centre_from_corner_px(camera: Camera) -> tuple[float, float]:
    """The principal point where (0, 0) is the corner of the image, as COLMAP and NeRF count [px].

    >>> centre_from_corner_px(Camera("c", 640, 480, pixel_um=2.0, focal_length_mm=4.0))
    (320.0, 240.0)
    """
    x, y = camera.centre_px
    return x + 0.5, y + 0.5


def in_file_world(pose: NDArray[np.float64], world: World) -> NDArray[np.float64]:
    """A (4, 4) pose in a world as one in the coordinates of the file that the world was read from [m]."""
    moved = np.array(pose, np.float64)
    moved[:3, 3] += world.origin_m
    return moved
