"""The measuring bench: what stands where, and how bright it is."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.values import Exposure
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tacos_plugins.scenes.bench.grey_bars import GreyBars
from tests.small_worlds import camera, rig


def seen(illumination_lux: float = 2000.0, **config) -> np.ndarray:
    """Luminance of a camera 0.5 m off that sees the target of 0.13 x 0.10 m and a margin [cd/m2]."""
    episode = GreyBars(GreyBars.Config(**config)).episode(illumination_lux=illumination_lux)
    looking = rig(camera(280, 220, focal_px=1000.0))
    capture = AnalyticRenderer(AnalyticRenderer.Config()).capture(episode, rig=looking, exposure=Exposure())
    return capture.views[0].luminance_cd_m2[0, ..., 1]


def test_the_mean_illuminance_on_the_target_is_the_scenario_s():
    light = seen(bars=3, darkest=0.5, brightest=0.5)
    on_target = light[light > 0.5 * light.max()]
    assert np.pi * on_target.mean() / 0.5 == pytest.approx(2000.0, rel=0.02)
    assert np.ptp(on_target) / on_target.mean() < 0.4


def test_bars_rise_evenly_from_black_on_the_left_to_white_on_the_right():
    row = seen(bars=5, brightest=0.8)[110]
    edges = np.linspace(140 - 130, 140 + 130, 6)
    middles = row[((edges[1:] + edges[:-1]) / 2).astype(int)]
    assert middles[0] == 0.0
    np.testing.assert_allclose(middles / middles[-1], [0, 0.25, 0.5, 0.75, 1.0], atol=0.03)


def test_there_is_nothing_but_the_target():
    light = seen()
    assert light[:5].max() == 0.0
    assert light[:, :5].max() == 0.0


def test_other_settings_are_other_worlds():
    keys = {
        GreyBars(GreyBars.Config(**config)).episode(illumination_lux=lux).world.key
        for config, lux in [({}, 100.0), ({}, 200.0), ({"bars": 8}, 100.0), ({"distance_m": 0.6}, 100.0)]
    }
    assert len(keys) == 4
