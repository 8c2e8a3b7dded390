"""The sensor."""

from __future__ import annotations

import numpy as np
from tacos_framework import Exposure
from tacos_framework.testing import SensorConformance
from tacos_framework.testing.forming import expose
from tacos_framework.testing.samples import sample_capture

from tacos_example.monochrome import MonochromeSensor


class TestMonochromeSensor(SensorConformance):
    component = MonochromeSensor


def test_noise_is_that_of_counted_electrons() -> None:
    sensor = MonochromeSensor(MonochromeSensor.Config(full_well_e=2000.0, read_noise_e=0.0))
    capture, exposure = sample_capture(luminance_cd_m2=8.0), Exposure(0.030, 2.0, 0.0)
    images = [expose(sensor, capture, exposure=exposure, seed=seed).images[0] for seed in range(40)]
    mean, variance = np.mean(images, axis=0), np.var(images, axis=0, ddof=1)
    inside = (mean > 20) & (mean < 200)
    expected = mean[inside] * 255 / 2000 + 1 / 12  # rounding adds 1/12
    np.testing.assert_allclose(np.mean(variance[inside] / expected), 1.0, rtol=0.02)
