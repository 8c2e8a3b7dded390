"""Effects of geometry: where each pixel of the real camera looks, in pixels of the ideal one."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tacos_validation.blind.generators.camera import IdealShot, Image
from tacos_validation.blind.generators.injected_effect import InjectedEffect


class InjectedLateralChromaticAberration(InjectedEffect, name="lateral-chromatic-aberration"):
    """Red and blue focused at other radii than green."""

    red: float = 0.0
    blue: float = 0.0
    red_r2: float = 0.0
    blue_r2: float = 0.0

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        """Undo R = r (1 + c + b r^2) by Newton's method."""
        c, b = ((self.red, self.red_r2), (0.0, 0.0), (self.blue, self.blue_r2))[channel]
        camera = shot.camera
        cx, cy = camera.centre_px
        full = np.hypot(camera.width_px, camera.height_px) / 2
        seen = np.hypot(x - cx, y - cy) / full
        true = seen.copy()
        for _ in range(5):
            true -= (true * (1 + c) + b * true**3 - seen) / (1 + c + 3 * b * true**2)
        ratio = np.divide(true, seen, out=np.ones_like(seen), where=seen > 0)
        return cx + (x - cx) * ratio, cy + (y - cy) * ratio


class InjectedLensDistortion(InjectedEffect, name="lens-distortion", place=1):
    """A lens that bends straight lines, by the plumb-line model, inverted by fixed point."""

    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        f = shot.camera.focal_px
        cx, cy = shot.camera.centre_px
        put = (x - cx) / f + 1j * (y - cy) / f
        true = put.copy()
        for _ in range(30):
            a, b = true.real, true.imag
            square = a * a + b * b
            swell = 1 + square * (self.k1 + square * self.k2)
            slip = (2 * self.p1 * a * b + self.p2 * (square + 2 * a * a)) + 1j * (
                self.p1 * (square + 2 * b * b) + 2 * self.p2 * a * b
            )
            true = (put - slip) / swell
        return cx + f * true.real, cy + f * true.imag


class InjectedFocalLengthError(InjectedEffect, name="focal-length-error", place=2):
    """Another focal length and principal point."""

    scale: float = 1.0
    dx_px: float = 0.0
    dy_px: float = 0.0

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        cx, cy = shot.camera.centre_px
        f = shot.camera.focal_px
        tan_x = (x - cx - self.dx_px) / (f * self.scale)
        tan_y = (y - cy - self.dy_px) / (f * self.scale)
        return cx + f * tan_x, cy + f * tan_y


class InjectedPoseError(InjectedEffect, name="pose-error", place=3):
    """The camera stands and looks otherwise than believed; what it sees is a plane."""

    rx: float = 0.0
    ry: float = 0.0
    rz: float = 0.0
    tx: float = 0.0
    ty: float = 0.0
    tz: float = 0.0

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        if not shot.has_pose:
            return x, y
        f, (cx, cy) = shot.camera.focal_px, shot.camera.centre_px
        turn = Rotation.from_rotvec([self.rx, self.ry, self.rz], degrees=True)
        rays = turn.apply(np.column_stack([(x.ravel() - cx) / f, (y.ravel() - cy) / f, np.ones(x.size)]))
        eye = np.array([self.tx, self.ty, self.tz]) * 1e-3
        along = (shot.depth_m - eye[2]) / rays[:, 2]
        met = eye + rays * along[:, None]
        return (
            cx + f * met[:, 0].reshape(x.shape) / shot.depth_m,
            cy + f * met[:, 1].reshape(x.shape) / shot.depth_m,
        )


class InjectedRollingShutter(InjectedEffect, name="rolling-shutter", place=4):
    """A shutter that exposes rows one after another."""

    row_time_us: float = 0.0

    def rays(self, x: Image, y: Image, channel: int, shot: IdealShot, row: Image) -> tuple[Image, Image]:
        later_s = row * self.row_time_us * 1e-6
        return x - shot.velocity_px_s[0] * later_s, y - shot.velocity_px_s[1] * later_s
