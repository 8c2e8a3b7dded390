"""Light transport inside a world: direct light, light after reflections, and its calibration in lux.

Pure functions on a `tacos_framework.values.World`, traced with Embree. Irradiance is kept per linear-sRGB
channel, scaled so that white light has equal channels; :func:`photopic` turns it into lux.
"""

from __future__ import annotations

from tacos_plugins.lighting.calibration import scale_light, with_illuminance
from tacos_plugins.lighting.emitters import emitter_luminance_cd_m2, photopic, white_at
from tacos_plugins.lighting.transport import LightTransport, bake_indirect, irradiance_at

__all__ = [
    "LightTransport",
    "bake_indirect",
    "emitter_luminance_cd_m2",
    "irradiance_at",
    "photopic",
    "scale_light",
    "white_at",
    "with_illuminance",
]
