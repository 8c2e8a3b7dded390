"""The ring of cameras."""

from __future__ import annotations

import numpy as np
from tacos_framework.testing import RigConformance

from tacos_example.panorama import PanoramaRig


class TestPanoramaRig(RigConformance):
    component = PanoramaRig
    variables = {"hfov_deg": 90.0, "cameras": 4}


def test_cameras_look_into_all_quarters() -> None:
    variables = PanoramaRig.Variables(hfov_deg=90.0, cameras=4)
    axes = [
        camera.agent_from_camera[:3, 2]
        for camera in PanoramaRig(PanoramaRig.Config()).build(variables).cameras
    ]
    np.testing.assert_allclose(axes, [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], atol=1e-12)
    assert PanoramaRig(PanoramaRig.Config()).derived(variables)["coverage"] == 1.0
