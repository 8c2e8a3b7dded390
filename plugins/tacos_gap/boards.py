"""Chessboards: corners against a pinhole whose pose is fitted to each view.

Only what no pose can explain is left, so that distance and tilt are never taken for the lens.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.motion import Places
from tacos_framework.contracts import formation_order, moves_pixels
from tacos_framework.formation import PlacedEffect, in_image_units
from tacos_framework.plugins.guarded import calling
from tacos_framework.randomness import generator
from tacos_framework.values import ContextMissing, ImageContext, ImageGeometry
from tacos_gap.captures import RealCapture
from tacos_gap.evidence import N_NULL_REPLICATES, Label, ReplicateResiduals

CORNER_PX = 0.12
"""Standard deviation of a detected corner [px]."""

MARGIN_PX = 0.16
"""Equivalence margin: boards are not flat to less, nor squares square [px]."""


def find_corners(capture: RealCapture) -> NDArray[np.float64] | None:
    """(K, 2) corners of the board in the mean of the frames, in its order; None if not all are seen."""
    assert capture.board is not None
    image = capture.real_dn.mean(axis=0).mean(axis=-1)
    low, high = np.percentile(image, (0.5, 99.5))
    if high <= low:
        return None
    grey = np.clip((image - low) * (255 / (high - low)), 0, 255).astype(np.uint8)
    found, corners = cv2.findChessboardCorners(grey, capture.board.inner_corners)
    if not found:
        found, corners = cv2.findChessboardCornersSB(grey, capture.board.inner_corners)
        return np.asarray(corners, np.float64).reshape(-1, 2) if found else None
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 40, 0.001)
    reach = int(np.clip(_spacing_px(corners.reshape(-1, 2)) * 0.4, 3, 11))
    refined = cv2.cornerSubPix(grey, corners, (reach, reach), (-1, -1), criteria)
    return np.asarray(refined, np.float64).reshape(-1, 2)


def _spacing_px(corners: NDArray[np.floating]) -> float:
    """Least distance between neighbours along the board's rows [px]."""
    return float(np.hypot(*np.diff(corners, axis=0).T).min())


class BoardEvidence:
    """Corners of one view of a board.

    Parameters
    ----------
    capture
        A capture of kind board.
    corners_px
        (K, 2) what `find_corners` saw in it.
    seed
        Seeds the noise floor.
    """

    def __init__(
        self,
        capture: RealCapture,
        corners_px: NDArray[np.float64],
        seed: int,
        replicates: int = N_NULL_REPLICATES,
    ):
        assert capture.board is not None
        self.capture = capture
        self.corners_px = corners_px
        columns, rows = capture.board.inner_corners
        grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
        self._points_mm = np.column_stack([grid * capture.board.square_mm, np.zeros(len(grid))])
        geometry = capture.geometry
        self._camera = np.array(
            [
                [geometry.focal_length_px, 0, geometry.centre_px[0]],
                [0, geometry.focal_length_px, geometry.centre_px[1]],
                [0, 0, 1],
            ]
        )
        self._sigma_px = np.hypot(CORNER_PX, MARGIN_PX)
        radius = np.hypot(*(corners_px - geometry.centre_px).T) / geometry.half_diagonal_px
        self.labels = [
            Label(
                capture.id,
                "board",
                "board_corners",
                "optics",
                {"radius": [round(float(r), 2)] * 2, "axis": axis},
            )
            for axis in "xy"
            for r in radius
        ]
        self.null_replicates = self._make_null_replicates(seed, replicates)

    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        """See `tacos_gap.evidence.Evidence`; only effects that move pixels bear on it."""
        in_order = sorted(effects, key=lambda effect: formation_order(effect.cls), reverse=True)
        sources = [s for e in in_order if (s := source_of(e, self.capture.geometry)) is not None]
        if not sources:
            return self._misfit(self.corners_px)

        def pinhole(places: NDArray[np.float64]) -> NDArray[np.float64]:
            for source in sources:
                places = _looked_up(source, places)
            return places

        here = pinhole(self.corners_px)
        right, low = np.array([0.5, 0.0]), np.array([0.0, 0.5])
        across = pinhole(self.corners_px + right) - pinhole(self.corners_px - right)
        down = pinhole(self.corners_px + low) - pinhole(self.corners_px - low)
        misfit = self._misfit(here).reshape(2, -1).T
        # corners are found in the image, not in the pinhole's: there an error of a pixel may be larger
        seen = np.linalg.solve(np.stack([across, down], axis=-1), misfit[..., None])[..., 0]
        return np.asarray(seen.T.ravel())

    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        """See `tacos_gap.evidence.Evidence`: corners are found as well, whatever the lens."""
        z = self.residual(effects)
        return ReplicateResiduals(z, self.null_replicates, np.ones_like(z))

    def _misfit(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        solved, rotation, shift = cv2.solvePnP(
            self._points_mm, places, self._camera, None, flags=cv2.SOLVEPNP_ITERATIVE
        )
        if not solved:
            return np.full(2 * len(places), 1e3)
        seen = cv2.projectPoints(self._points_mm, rotation, shift, self._camera, None)[0].reshape(-1, 2)
        return np.asarray((places - seen).T.ravel() / self._sigma_px)

    def _make_null_replicates(self, seed: int, replicates: int) -> NDArray[np.float64]:
        """A perfect view with the noise of detection, its pose refitted."""
        rng = generator(seed, "board", self.capture.id)
        _, rotation, shift = cv2.solvePnP(self._points_mm, self.corners_px, self._camera, None)
        perfect = cv2.projectPoints(self._points_mm, rotation, shift, self._camera, None)[0].reshape(-1, 2)
        noise = rng.normal(scale=CORNER_PX, size=(replicates, *perfect.shape))
        return np.stack([self._misfit(perfect + n) for n in noise])


def source_of(placed: PlacedEffect, geometry: ImageGeometry) -> Places | None:
    """Where each pixel looks through an effect that does nothing but move pixels, and needs no circumstances.

    None for all others, as for those that go by motion or depth.
    """
    if not moves_pixels(placed.cls):
        return None
    nothing = ImageContext()
    with calling(placed.use, doing="source"):
        effect = placed.cls(in_image_units(placed.config, placed.use, geometry, nothing))
        try:
            places: Places | None = effect.source(geometry=geometry, context=nothing, frames=1)
        except ContextMissing:
            return None
        if places is None:
            return None
        x, y = (np.reshape(part, (geometry.height_px, geometry.width_px)) for part in places)
    return x, y


def _looked_up(source: Places, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where pixels at `places` look, between the whole pixels that `source` gives."""
    x, y = (np.ascontiguousarray(part, np.float32) for part in source)
    at_x, at_y = (np.ascontiguousarray(part, np.float32)[None] for part in places.T)
    found = [
        cv2.remap(part, at_x, at_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0] for part in (x, y)
    ]
    return np.column_stack(found).astype(np.float64)
