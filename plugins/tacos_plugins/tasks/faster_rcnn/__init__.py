"""The task `task.faster-rcnn`: an object detector, trained and scored."""

from __future__ import annotations

import tacos_plugins.tasks.learning  # noqa: F401 - before torchvision, which would import triton beside OpenGL
