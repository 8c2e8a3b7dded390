"""The renderer."""

from __future__ import annotations

import numpy as np
from tacos_framework.testing import RendererConformance
from tacos_framework.testing.samples import sample_episode, sample_rig

from tacos_example.integrating_sphere import IntegratingSphere


class TestIntegratingSphere(RendererConformance):
    component = IntegratingSphere


def test_luminance_follows_ulbricht() -> None:
    episode = sample_episode(frames=1)
    world = episode.world
    renderer = IntegratingSphere(IntegratingSphere.Config())
    luminance = renderer.capture(episode, rig=sample_rig()).views[0].luminance_cd_m2[0, 24, 0, 0]  # a wall
    area_m2 = {0.5: 5.0 * 8.0 + 8.0 * 3.0, 0.1: 0.4 * 0.4}  # of each reflectance
    mean = sum(reflectance * area for reflectance, area in area_m2.items()) / sum(area_m2.values())
    illuminance_lux = world.lights[0].flux_lm[0] / (sum(area_m2.values()) * (1 - mean))
    np.testing.assert_allclose(luminance, 0.5 * illuminance_lux / np.pi, rtol=1e-5)
