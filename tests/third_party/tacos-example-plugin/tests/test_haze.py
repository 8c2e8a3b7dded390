"""The effect."""

from __future__ import annotations

import numpy as np
import pytest
from tacos_framework import ContextMissing, ImageContext, ImageGeometry
from tacos_framework.testing import EffectConformance

from tacos_example.haze import Haze

GEOMETRY = ImageGeometry(2, 1, focal_length_px=1e6, centre_px=(0.5, 0.0), pixel_um=3.0)


class TestHaze(EffectConformance):
    component = Haze
    config = {"extinction_per_m": 0.2}


def test_contrast_falls_exponentially_with_distance() -> None:
    light = np.array([0.0, 2.0]).reshape(1, 1, 2, 1)
    context = ImageContext(depth_m=np.full((1, 2), 10.0))
    haze = Haze(Haze.Config(extinction_per_m=0.1))
    seen = haze.on_array(light, geometry=GEOMETRY, context=context, rng=np.random.default_rng(1)).ravel()
    np.testing.assert_allclose((seen[1] - seen[0]) / 2.0, np.exp(-1.0), rtol=1e-6)
    np.testing.assert_allclose(seen.mean(), 1.0)


def test_without_distances_it_says_what_is_missing() -> None:
    haze = Haze(Haze.Config(extinction_per_m=0.1))
    with pytest.raises(ContextMissing, match="needs the distance"):
        haze.on_array(
            np.ones((1, 1, 2, 1)), geometry=GEOMETRY, context=ImageContext(), rng=np.random.default_rng(1)
        )
