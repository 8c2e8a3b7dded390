"""A camera that is not where the simulator believes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tacos_framework import ImageContext, ImageGeometry, Settings, ShownBy, Stage, setting
from tacos_framework.camera import Places, inverse_depth, invert_pose, reprojected, resample_inverse_depth
from tacos_plugins.effects.pixel_sources import source_of
from tacos_plugins.effects.shown_by import PLACES


class PoseError:
    """Sees the scene from the real pose, while the believed pose stays in the data.

    The real camera's frame lies (tx, ty, tz) from the believed one's and is turned by the rotation vector
    (rx, ry, rz), both along the believed camera's axes: x to the right, y downwards, z forward. A turn alone
    is exact and needs no depth. A shift moves near things more, by the depth of each pixel; what it uncovers
    is not known, and the rim of its surroundings is drawn out there. Depth and ids of a capture are those of
    the pixels of the real camera, `world_from_camera` is the believed pose.
    """

    class Config(Settings):
        rx: float = setting(0.0, help="Turn about the x axis; above 0 looks up.", unit="deg", ge=-45, le=45)
        ry: float = setting(
            0.0, help="Turn about the y axis; above 0 looks right.", unit="deg", ge=-45, le=45
        )
        rz: float = setting(
            0.0, help="Turn about the optical axis; above 0 rolls clockwise.", unit="deg", ge=-180, le=180
        )
        tx: float = setting(0.0, help="Shift to the right.", unit="mm", ge=-1e4, le=1e4)
        ty: float = setting(0.0, help="Shift downwards.", unit="mm", ge=-1e4, le=1e4)
        tz: float = setting(0.0, help="Shift forward.", unit="mm", ge=-1e4, le=1e4)

    stage: ClassVar[Stage] = "scene"
    rank: ClassVar[int] = 0
    neutral: ClassVar[Mapping[str, Any]] = dict.fromkeys(("rx", "ry", "rz", "tx", "ty", "tz"), 0.0)
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"rx": 0.2}, {"ry": 0.2}, {"rz": 0.3})
    shown_by: ClassVar[Sequence[ShownBy]] = (PLACES,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def _off(self) -> bool:
        return not any(getattr(self.config, name) for name in self.neutral)

    @property
    def real_from_believed(self) -> NDArray[np.float64]:
        """(4, 4) transform of points from the believed camera's frame to the real one's [m]."""
        c = self.config
        believed_from_real = np.eye(4)
        turn = Rotation.from_rotvec([c.rx, c.ry, c.rz], degrees=True)
        believed_from_real[:3, :3] = turn.as_matrix()
        believed_from_real[:3, 3] = np.array([c.tx, c.ty, c.tz]) * 1e-3
        return invert_pose(believed_from_real)

    def moved_inverse_depth(
        self,
        near: NDArray[np.floating],
        columns: NDArray[np.float64],
        rows: NDArray[np.float64],
        *,
        geometry: ImageGeometry,
    ) -> NDArray[np.floating]:
        """One over the depth from the real pose, of what lies at those places of the believed image [1/m]."""
        scale = reprojected(columns, rows, near, geometry, self.real_from_believed)[2]
        return np.asarray(near / scale)

    def source(self, *, geometry: ImageGeometry, context: ImageContext, frames: int) -> Places | None:
        """Places in the believed image at which pixels of the real one look, (N, H, W) or (H, W) [px]."""
        if self._off:
            return None
        transform = self.real_from_believed
        c = self.config
        if not (c.tx or c.ty or c.tz):
            cx, cy = geometry.centre_px
            x, y = np.broadcast_arrays(geometry.x_px + cx, geometry.y_px + cy)
            x, y, _ = reprojected(x, y, np.zeros(()), geometry, invert_pose(transform))
            return x, y
        depth_m = context.known_depth_m("effect.pose-error with a shift")
        size = (frames, geometry.height_px, geometry.width_px)
        near = np.broadcast_to(inverse_depth(depth_m), size)

        def seen(x: NDArray[np.float64], y: NDArray[np.float64]) -> Places:
            return reprojected(x, y, resample_inverse_depth(near, x, y), geometry, transform)[:2]

        return source_of(geometry, seen, frames)
