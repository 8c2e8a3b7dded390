"""All views of all boards together: poses, paper and an unstated lens are fitted, and what is left is told.

The bundle adjustment of photogrammetry (Triggs et al. 2000, "Bundle Adjustment - A Modern Synthesis"), with
one difference: the lens is not fitted but given, as a hypothesis' effects. Poses are eliminated view by view.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import ImageGeometry
from tacos_framework.formation import PlacedEffect
from tacos_gap.captures.capture import Board
from tacos_gap.evidence.boards.imaged import imaged
from tacos_gap.evidence.boards.paper import FEWEST_VIEWS, MOST, deformations
from tacos_gap.evidence.boards.pose import Pose, first_pose, moved_pose
from tacos_gap.evidence.boards.tracing import moving, traced

ROUNDS = 8
"""Most Gauss-Newton steps."""

CONVERGED = 1e-5
"""Relative gain below which they stop."""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class View:
    """One view of a board. `sigma_px`: standard deviation that one coordinate is allowed [px]."""

    board: Board
    points_mm: Array
    corners_px: Array
    sigma_px: float
    geometry: ImageGeometry


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Residuals of the corners, and what was fitted to them."""

    residuals: tuple[Array, ...]  # for each view (2K,), all x before all y [sigma]
    shared: Array  # (S,) what the views share, in units of its prior: paper board by board, then the lens
    poses: tuple[Pose, ...]


class Bundle:
    """Views of boards by one camera."""

    def __init__(self, views: Sequence[View], unstated: frozenset[str] = frozenset()):
        self.views = tuple(views)
        boards = [view.board for view in self.views]
        self._papers = [board for board in dict.fromkeys(boards) if boards.count(board) >= FEWEST_VIEWS]
        self._bends = [deformations(view.board, view.points_mm) for view in self.views]
        ways = [len(self._bends[boards.index(board)]) for board in self._papers]
        self._starts = np.cumsum([0, *ways])
        self._lens = _lens_names(unstated)
        self._priors = np.concatenate([np.ones(self._starts[-1]), [_LENS_PRIOR[name] for name in self._lens]])
        self._kept: dict[str, Adjusted] = {}

    def adjusted(self, effects: Sequence[PlacedEffect]) -> Adjusted:
        """Adjustment under effects; those that move no pixels change nothing."""
        bearing = moving(effects)
        key = repr([(effect.use, effect.config) for effect in bearing])
        if key not in self._kept:
            self._kept[key] = self._adjust(bearing)
        return self._kept[key]

    def noise_left(self, noise_px: Sequence[Array]) -> list[Array]:
        """Residual of noise on corners of a flat board seen by a pinhole, after adjustment to first order.

        - `noise_px`: for each view (B, K, 2) draws [px].

        Returns: for each view (B, 2K), as `Adjusted.residuals` [sigma].
        """
        poses = self.adjusted(()).poses
        flat = np.zeros(len(self._priors))
        normal = np.diag(self._priors)
        gradient: Array = np.zeros((len(flat), len(noise_px[0])))
        parts = []
        for i, (view, noise) in enumerate(zip(self.views, noise_px, strict=True)):
            _, by_pose, by_shared = self._projected(i, poses[i], flat)
            upright = np.linalg.qr(by_pose / view.sigma_px)[0]
            z = noise.transpose(2, 1, 0).reshape(-1, len(noise)) / view.sigma_px
            shared = by_shared / view.sigma_px
            z, shared = (part - upright @ (upright.T @ part) for part in (z, shared))
            normal = normal + shared.T @ shared
            gradient = gradient + shared.T @ z
            parts.append((z, shared))
        moved = np.linalg.solve(normal, gradient) if len(flat) else gradient
        return [(z - shared @ moved).T for z, shared in parts]

    def bend(self, view: int, effects: Sequence[PlacedEffect]) -> Array:
        """(S,) how far the paper of a view's board bends, told of its first view alone [standard deviations].

        It counts in the score as any residual does: a bend beyond what paper does explains nothing.
        """
        board = self.views[view].board
        if board not in self._papers or [each.board for each in self.views].index(board) != view:
            return np.zeros(0)
        place = self._papers.index(board)
        return self.adjusted(effects).shared[self._starts[place] : self._starts[place + 1]]

    def nuisances(self, view: int, effects: Sequence[PlacedEffect]) -> dict[str, Any]:
        found = self.adjusted(effects)
        board = self.views[view].board
        told: dict[str, Any] = {}
        if board in self._papers:
            place = self._papers.index(board)
            bend = found.shared[self._starts[place] : self._starts[place + 1]]
            out_of_plane = np.tensordot(bend, self._bends[view], axes=1)[:, 2]
            told["paper_sag_mm"] = float(np.ptp(out_of_plane))
        if "focal_length" in self._lens:
            f = self.views[view].geometry.focal_length_px
            told["focal_length_px"] = f * float(np.exp(found.shared[self._starts[-1]]))
        return told

    # the adjustment ---------------------------------------------------------------------------------------

    def _adjust(self, effects: Sequence[PlacedEffect]) -> Adjusted:
        seen = self._traced(effects)
        poses = tuple(
            first_pose(view.points_mm, places, view.geometry)
            for view, (places, _) in zip(self.views, seen, strict=True)
        )
        best = self._at(seen, poses, np.zeros(len(self._priors)))
        cost = self._cost(best)
        for _ in range(ROUNDS):
            step = self._step(seen, best)
            for share in (1.0, 0.5, 0.2, 0.05):
                changed = self._at(
                    seen,
                    tuple(
                        moved_pose(pose, share * move) for pose, move in zip(best.poses, step[0], strict=True)
                    ),
                    self._within(best.shared + share * step[1]),
                )
                if (lower := self._cost(changed)) < cost:
                    break
            else:
                break
            gain, best, cost = 1 - lower / cost, changed, lower
            if gain < CONVERGED:
                break
        return best

    def _traced(self, effects: Sequence[PlacedEffect]) -> list[tuple[Array, Array]]:
        """See `traced`, for each view; those of one geometry together, as maps of whole images are costly."""
        found: dict[int, tuple[Array, Array]] = {}
        for geometry in dict.fromkeys(view.geometry for view in self.views):
            members = [i for i, view in enumerate(self.views) if view.geometry == geometry]
            corners = [self.views[i].corners_px for i in members]
            parts = traced(effects, geometry, np.concatenate(corners))
            ends = np.cumsum([len(each) for each in corners])[:-1]
            places, inverses = (np.split(part, ends) for part in parts)
            found |= dict(zip(members, zip(places, inverses, strict=True), strict=True))
        return [found[i] for i in range(len(self.views))]

    def _within(self, shared: Array) -> Array:
        paper = self._starts[-1]
        return np.concatenate([np.clip(shared[:paper], -MOST, MOST), shared[paper:]])

    def _cost(self, adjusted: Adjusted) -> float:
        size = float(sum(z @ z for z in adjusted.residuals) + adjusted.shared**2 @ self._priors)
        return size if np.isfinite(size) else np.inf

    def _at(self, seen: Sequence[tuple[Array, Array]], poses: tuple[Pose, ...], shared: Array) -> Adjusted:
        residuals = []
        for i, (places, inverse) in enumerate(seen):
            projected, _, _ = self._projected(i, poses[i], shared, derivatives=False)
            misfit = np.einsum("kij,kj->ki", inverse, places - projected)
            residuals.append(misfit.T.ravel() / self.views[i].sigma_px)
        return Adjusted(tuple(residuals), shared, poses)

    def _step(self, seen: Sequence[tuple[Array, Array]], at: Adjusted) -> tuple[list[Array], Array]:
        """The Gauss-Newton step of (6,) for each pose, and of what is shared."""
        normal, gradient = np.diag(self._priors), -self._priors * at.shared
        parts = []
        for i, (_, inverse) in enumerate(seen):
            _, by_pose, by_shared = self._projected(i, at.poses[i], at.shared)
            by_pose, by_shared = (
                np.einsum("kij,jkp->ikp", inverse, by.reshape(2, len(inverse), -1)).reshape(by.shape)
                / self.views[i].sigma_px
                for by in (by_pose, by_shared)
            )
            upright, triangle = np.linalg.qr(by_pose)
            z = at.residuals[i]
            shared = by_shared - upright @ (upright.T @ by_shared)
            normal = normal + shared.T @ shared
            gradient = gradient + shared.T @ z
            parts.append((upright, triangle, by_shared, z))
        moved: Array = np.asarray(np.linalg.lstsq(normal, gradient, rcond=None)[0], np.float64)
        poses = [
            np.linalg.lstsq(triangle, upright.T @ (z - by_shared @ moved), rcond=None)[0]
            for upright, triangle, by_shared, z in parts
        ]
        return poses, moved

    def _projected(
        self, i: int, pose: Pose, shared: Array, *, derivatives: bool = True
    ) -> tuple[Array, Array, Array]:
        """Places where the believed lens sees the points of a view, (K, 2) [px], and their derivatives.

        With its pose, (2K, 6), and with what is shared, (2K, S), all x before all y.
        """
        view, bends = self.views[i], self._bends[i]
        points = view.points_mm
        own = slice(0, 0)
        if view.board in self._papers:
            place = self._papers.index(view.board)
            own = slice(int(self._starts[place]), int(self._starts[place + 1]))
            points = points + np.tensordot(shared[own], bends, axes=1)
        lens = dict(zip(self._lens, shared[self._starts[-1] :], strict=True))
        f = view.geometry.focal_length_px * float(np.exp(lens.get("focal_length", 0.0)))
        turned = points @ pose.rotation.T
        x, y = np.add(view.geometry.centre_px, (lens.get("centre_x", 0.0), lens.get("centre_y", 0.0)))
        seen_by = replace(view.geometry, focal_length_px=f, centre_px=(float(x), float(y)))
        places, by_point = imaged(turned + pose.shift_mm, seen_by, derivatives=derivatives)
        if not derivatives:
            return places, np.zeros((0, 6)), np.zeros((0, 0))
        a, b, c = turned.T
        none = np.zeros_like(a)
        turning = np.stack([[none, c, -b], [-c, none, a], [b, -a, none]]).transpose(2, 1, 0)  # (K, axis, xyz)
        by_pose = np.concatenate([np.einsum("iks,kps->ikp", by_point, turning), by_point], axis=2)
        by_shared = np.zeros((2, len(points), len(shared)))
        if own.stop > own.start:
            by_shared[:, :, own] = np.einsum("iks,pks->ikp", by_point, bends @ pose.rotation.T)
        for k, name in enumerate(self._lens, start=int(self._starts[-1])):
            from_centre = (places - seen_by.centre_px).T  # every projection is as large as its focal length
            moves: Any = {"focal_length": from_centre, "centre_x": (1.0, 0.0), "centre_y": (0.0, 1.0)}[name]
            by_shared[0, :, k], by_shared[1, :, k] = moves
        count = 2 * len(points)
        return places, by_pose.reshape(count, 6), by_shared.reshape(count, len(shared))


_LENS_PRIOR = {"focal_length": 1e-4, "centre_x": 1e-8, "centre_y": 1e-8}
"""Weights so small that they settle only what no view does."""


def _lens_names(unstated: frozenset[str]) -> tuple[str, ...]:
    names = ("focal_length",) if "focal_length" in unstated else ()
    return (*names, "centre_x", "centre_y") if "principal_point" in unstated else names
