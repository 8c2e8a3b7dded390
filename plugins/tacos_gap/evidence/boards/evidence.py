"""Boards as evidence: corners against a pinhole whose pose is fitted to each view.

Only what neither poses nor paper can explain is left, so that distance and tilt are never taken for the lens.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import generator
from tacos_framework.formation import PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.evidence import N_NULL_REPLICATES, Label, ReplicateResiduals
from tacos_gap.evidence.boards.bundle import Bundle, View
from tacos_gap.evidence.boards.corner_noise import smooth_residual, steadied
from tacos_gap.evidence.boards.tracing import traced

MARGIN = 1e-4
"""Equivalence margin of a corner, over the image's diagonal [1]: .08 pixels of 640 x 480."""


class BoardEvidence:
    """Corners of one view of a board, beside all others.

    `noise_px`: standard deviation of its corners by detection [px]. `null_replicates`: (B, 2K + S) what the
    adjustment leaves of a noise-floor unit on every corner, and paper as it comes [noise floor].
    """

    def __init__(
        self,
        capture: RealCapture,
        bundle: Bundle,
        place: int,
        noise_px: float,
        null_replicates: NDArray[np.float64],
    ):
        assert capture.corners is not None
        self.capture = capture
        self.corners_px = capture.corners[1]
        self.noise_px = noise_px
        self.null_replicates = null_replicates
        self._bundle = bundle
        self._place = place
        geometry = capture.geometry
        radius = np.hypot(*(self.corners_px - geometry.centre_px).T) / geometry.half_diagonal_px
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
        ways = self._bundle.bend(place, ())
        self.labels += [
            Label(capture.id, "board", "board_flatness", "scene", {"way": k}) for k in range(len(ways))
        ]

    @property
    def sigma_px(self) -> float:
        """One noise-floor unit: noise of detection and equivalence margin together [px]."""
        return self._bundle.views[self._place].sigma_px

    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        """See `tacos_gap.evidence.Evidence`; only effects that move pixels bear on it."""
        corners = self._bundle.adjusted(effects).residuals[self._place]
        return np.concatenate([corners, self._bundle.bend(self._place, effects)])

    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        """See `tacos_gap.evidence.Evidence`: corners are found as well, whatever the lens."""
        z = self.residual(effects)
        return ReplicateResiduals(z, self.null_replicates, np.ones_like(z))

    def moves(self, effect: PlacedEffect) -> bool:
        """True if an effect moves the corners by a noise-floor unit, whatever pose may take it up."""
        moved_px = traced([effect], self.capture.geometry, self.corners_px)[0] - self.corners_px
        return bool(np.mean(moved_px**2) > self.sigma_px**2)

    def nuisances(self, effects: Sequence[PlacedEffect]) -> dict[str, Any]:
        return self._bundle.nuisances(self._place, effects)


def evidence_of_boards(
    captures: Sequence[RealCapture], seed: int, replicates: int = N_NULL_REPLICATES
) -> list[BoardEvidence]:
    """Evidence of all views of boards by one camera; their noise is what the views themselves show.

    `replicates`: replicates it is made of.
    """
    if not captures:
        return []
    noises_px = steadied(
        [smooth_residual(*c.corners, c.geometry.centre_px)[1] for c in captures if c.corners is not None]
    )
    views = [_view(capture, noise_px) for capture, noise_px in zip(captures, noises_px, strict=True)]
    bundle = Bundle(views, captures[0].unstated)
    draws = [
        generator(seed, "board", capture.id).normal(
            scale=view.sigma_px, size=(replicates, *view.corners_px.shape)
        )
        for capture, view in zip(captures, views, strict=True)
    ]
    left = bundle.noise_left(draws)
    found = []
    for place, capture in enumerate(captures):
        ways = len(bundle.bend(place, ()))
        paper = generator(seed, "paper", capture.id).normal(size=(replicates, ways))
        null_replicates = np.concatenate([left[place], paper], axis=1)
        found.append(BoardEvidence(capture, bundle, place, noises_px[place], null_replicates))
    return found


def _view(capture: RealCapture, noise_px: float) -> View:
    assert capture.board is not None
    assert capture.corners is not None
    geometry = capture.geometry
    margin_px = MARGIN * 2 * geometry.half_diagonal_px
    points_mm, corners_px = capture.corners
    return View(capture.board, points_mm, corners_px, float(np.hypot(noise_px, margin_px)), geometry)
