"""The ring of cameras."""

from __future__ import annotations

import numpy as np
from tacos_framework.testing import RigConformance

from tacos_example.ring import RingRig


class TestRingRig(RigConformance):
    component = RingRig
    variables = {"hfov_deg": 90.0, "cameras": 4}


def test_cameras_look_into_all_quarters() -> None:
    variables = RingRig.Variables(hfov_deg=90.0, cameras=4)
    axes = [camera.agent_from_camera[:3, 2] for camera in RingRig(RingRig.Config()).build(variables).cameras]
    np.testing.assert_allclose(axes, [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], atol=1e-12)
    assert RingRig(RingRig.Config()).derived(variables)["coverage"] == 1.0
