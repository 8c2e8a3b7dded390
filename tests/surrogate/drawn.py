"""Observations drawn from the model itself."""

from __future__ import annotations

import numpy as np

from tacos_plugins.surrogate.gaussian_process import Inputs, covariance, factorised
from tacos_plugins.surrogate.kernel import Hyperparameters

TRUE = Hyperparameters((0.4, 0.8, 3.0), signal=1.0, episode=0.3, interaction=0.2, noise=0.15)


def inputs_of(rng: np.random.Generator, count: int, episodes: int = 4) -> Inputs:
    """So many points in three dimensions, in scenes by turns."""
    return Inputs(rng.random((count, 3)), np.arange(count) % episodes)


def values_of(rng: np.random.Generator, inputs: Inputs, h: Hyperparameters = TRUE) -> np.ndarray:
    """Values observed there."""
    return factorised(covariance(inputs, h)) @ rng.standard_normal(len(inputs))
