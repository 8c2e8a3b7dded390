"""Worlds that differ in how strong their light is, drawn from light that was worked out once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_worlds import camera, matte, pose, quad, rig, standing, world

from tacos_framework.values import Exposure, Light, World
from tacos_plugins.lighting import scale_light
from tacos_plugins.renderers.moderngl import device
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

pytestmark = pytest.mark.gl


def luminance(place: World) -> np.ndarray:
    renderer = ModernglRenderer(ModernglRenderer.Config())
    view = renderer.capture(standing(place, pose((0, 0, 0))), rig=rig(camera()), exposure=Exposure()).views[0]
    return view.luminance_cd_m2


@pytest.mark.parametrize("factor", [0.003, 7.3])
def test_scaled_light_is_that_of_lighting_anew(factor: float, monkeypatch: pytest.MonkeyPatch) -> None:
    lamp = Light(np.array([0.5, 0.3, 1.0]), np.array([100.0, 90.0, 80.0]))
    wall = quad((2.0, 0.0, 0.0), (0, -0.5, 0), (0, 0, 0.5))
    floor = quad((1, 0, -0.5), (2, 0, 0), (0, 2, 0), 1)
    glowing = matte(emission_cd_m2=np.full(3, 2.0))
    place = world(
        [wall, floor, quad((1, 0.5, 0), (0.1, 0, 0), (0, 0, 0.1), 2)],
        [matte(0.7), matte(0.5, roughness=0.2, metallic=1.0), glowing],
        [lamp],
    )
    anew = luminance(scale_light(place, factor, key=f"anew {factor}"))
    luminance(place)

    def again(*_: object) -> None:
        raise AssertionError("light is worked out again")

    monkeypatch.setattr(device, "light_world", again)
    dim = scale_light(place, factor, key=f"dim {factor}")
    np.testing.assert_allclose(
        luminance(replace(dim, unscaled=place, light_factor=factor)), anew, rtol=2e-3, atol=1e-6 * anew.max()
    )
