"""`task.psmnet` passes the suite of tasks that learn."""

from __future__ import annotations

from typing import Any, ClassVar

import pytest

from tacos_framework.testing import TrainableConformance
from tests.tasks.stereo_frames import stereo_frames, stereo_rig

pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.psmnet.task import PsmnetDepth


class TestPsmnetDepth(TrainableConformance):
    component = PsmnetDepth
    config: ClassVar[dict[str, Any]] = {"width": 0.1, "max_disparity": 16, "device": "cpu"}

    def frames(self):
        return stereo_frames(stereo_rig(width_px=64, height_px=32, focal_length_px=60.0), sky_rows=4)
