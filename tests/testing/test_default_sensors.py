"""The default sensors pass the suite that third parties are given."""

# ruff: noqa: RUF012 - settings stand as plain class attributes, as plugin authors will write them

from __future__ import annotations

from dataclasses import replace

from tacos_framework import Camera
from tacos_framework.testing import SensorConformance
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.sensors.camera import CameraSensor
from tacos_plugins.sensors.emva import Emva


class TestAffineNoise(SensorConformance):
    component = AffineNoise


class TestAffineNoiseAtTwelveBits(SensorConformance):
    component = AffineNoise
    config = {"bit_depth": 12, "black_level_dn": 64}


class TestEmva(SensorConformance):
    component = Emva
    config = {"quantum_efficiency": 0.6, "full_well_e": 1e4, "read_noise_e": 3.0, "dark_current_e_s": 10.0}


class TestCameraSensor(SensorConformance):
    component = CameraSensor

    def camera(self, binning: float = 1.0) -> Camera:
        """Without filters: what a mosaic leaves out is shared by pixels, whose noise then averages less."""
        return replace(super().camera(binning), colour="mono")


class TestCameraSensorOfADraw(SensorConformance):
    component = CameraSensor
    config = {"assumptions": 3, "channels": "mono", "black_level_dn": 64}
