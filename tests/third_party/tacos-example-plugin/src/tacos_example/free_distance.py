"""Learns to tell from an image how far the way ahead is free."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray
from tacos_framework import Budget, FrameBatch, Scores, Settings, State, setting

THUMBNAIL_PX = (8, 6)
FEATURES = THUMBNAIL_PX[0] * THUMBNAIL_PX[1] + 1


class FreeDistance:
    """Ridge regression from a thumbnail of the first camera to the logarithm of the distance ahead.

    Its state is all that regression needs to remember of the frames: the Gram matrix of their features and
    the features' products with the target. Training adds to both, so it is exact and order does not matter.

    ``log_error``
        Mean absolute error of the natural logarithm of the distance; lower is better, so its weight in a
        fitness is negative.
    """

    class Config(Settings):
        ridge: float = setting(1e-3, help="Weight of the penalty on large coefficients.", gt=0)

    scores: ClassVar[tuple[str, ...]] = ("log_error",)

    def __init__(self, config: Config) -> None:
        self.config = config

    def initial_state(self, *, rng: np.random.Generator) -> State:
        """Nothing seen yet."""
        return {"gram": np.zeros((FEATURES, FEATURES)), "products": np.zeros(FEATURES)}

    def fit(
        self, batches: Iterable[FrameBatch], *, state: State, budget: Budget, rng: np.random.Generator
    ) -> State:
        """The state with the frames of the batches added; one pass tells all, so epochs change nothing."""
        gram, products = state["gram"].copy(), state["products"].copy()
        for frames in batches:
            features, targets = thumbnails(frames), log_distance_ahead(frames)
            gram += features.T @ features
            products += features.T @ targets
        return {"gram": gram, "products": products}

    def begin(self, *, state: State | None) -> DistanceScorer:
        """A scorer that predicts with `state`."""
        if state is None:
            raise ValueError("task.free-distance learns: it needs a state")
        gram = state["gram"] + self.config.ridge * np.eye(FEATURES)
        return DistanceScorer(np.linalg.solve(gram, state["products"]))


class DistanceScorer:
    """Sums up errors; keeps no frames."""

    def __init__(self, coefficients: NDArray[np.float64]) -> None:
        self._coefficients = coefficients
        self._errors: list[float] = []

    def update(self, frames: FrameBatch) -> None:
        for features, target in zip(thumbnails(frames), log_distance_ahead(frames), strict=True):
            self._errors.append(abs(float(features @ self._coefficients) - float(target)))

    def scores(self) -> Scores:
        """The mean error; no score without frames."""
        return {"log_error": float(np.mean(self._errors))} if self._errors else {}


def thumbnails(frames: FrameBatch) -> NDArray[np.float64]:
    """(N, FEATURES) brightness of a small image over full scale, and a one."""
    small = [cv2.resize(image, THUMBNAIL_PX, interpolation=cv2.INTER_AREA) for image in frames.images[0]]
    grey = np.array([image.reshape(*THUMBNAIL_PX[::-1], -1).mean(axis=-1).ravel() for image in small])
    return np.column_stack([grey / frames.white_level_dn, np.ones(len(grey))])


def log_distance_ahead(frames: FrameBatch) -> NDArray[np.float64]:
    """(N,) logarithm of the median depth in the middle of the first camera's image [ln m]."""
    depth_m = frames.capture.views[0].depth_m
    rows, columns = depth_m.shape[1] // 3, depth_m.shape[2] // 3
    middle = depth_m[:, rows : 2 * rows + 1, columns : 2 * columns + 1]
    median_m = np.median(middle.reshape(len(middle), -1), axis=1)
    return np.log(np.clip(median_m, 0.01, 1000.0).astype(np.float64))
