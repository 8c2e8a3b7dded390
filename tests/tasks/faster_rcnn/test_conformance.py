"""`task.faster-rcnn` passes the suite of tasks that learn."""

from __future__ import annotations

from typing import Any, ClassVar

import pytest
from toy_detection import squares

from tacos_framework.testing import TrainableConformance

pytest.importorskip("torchvision", reason="the extra perception is not installed")

from tacos_plugins.tasks.faster_rcnn.task import INDOOR_CLASSES, FasterRcnn


class TestFasterRcnn(TrainableConformance):
    component = FasterRcnn
    config: ClassVar[dict[str, Any]] = {"backbone": "narrow-fpn", "proposals": 30, "rois": 8, "device": "cpu"}

    def frames(self):
        return squares(4, width_px=96, height_px=64, classes=INDOOR_CLASSES)
