"""The control spares the highlights."""

from __future__ import annotations

import numpy as np
import pytest
from tacos_framework import Exposure, ImageContext
from tacos_framework.testing import ControlConformance

from tacos_example.highlights import Highlights


class TestHighlights(ControlConformance):
    component = Highlights


@pytest.mark.parametrize(("level_dn", "time_ms"), [(102, 20.0), (204, 10.0), (255, 5.0)])
def test_the_brightest_pixels_come_to_the_level(level_dn: int, time_ms: float) -> None:
    frame = np.full((4, 4, 1), level_dn, np.uint8)
    chosen = Highlights(Highlights.Config()).adjust(
        frame, exposure=Exposure(0.010), context=ImageContext(white_level_dn=255)
    )
    assert chosen.time_s == pytest.approx(time_ms * 1e-3)
