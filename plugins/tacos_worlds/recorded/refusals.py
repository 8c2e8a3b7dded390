"""Limits of a recording by its exposure and noise."""

from __future__ import annotations

import numpy as np

from tacos_framework import Camera, Exposure, Sensor
from tacos_worlds.recorded.recording import ExposedFrames
from tacos_worlds.recorded.source import Source

_BLUR_PX = 0.5
"""Blur in pixels of a candidate that does not show."""
_CLIPPED = 0.01
"""Share of clipped samples that does not show."""
_QUANTILES = (0.1, 0.5, 0.9)
"""Brightnesses at which noise is compared; at most of them a candidate has to be the noisier one."""


def of_exposure(
    source: Source, frames: ExposedFrames, exposure: Exposure, camera: Camera, recorded: Camera
) -> dict[str, str]:
    """Reasons why frames are more blurred by motion than a candidate's: a word or two -> a sentence."""
    shorter_ms = frames.exposure_ms - exposure.time_s * 1e3
    if shorter_ms <= 1e-3 * frames.exposure_ms:
        return {}
    moved_px = source.moved_px(shorter_ms) * camera.focal_length_px / recorded.focal_length_px
    if moved_px <= _BLUR_PX:
        return {}
    recorded_ms, own_ms = frames.exposure_ms, exposure.time_s * 1e3
    said = (
        f"the image moves {moved_px:.1f} px further in the recorded {recorded_ms:g} ms than in {own_ms:g} ms"
    )
    return {"a shorter exposure": said}


def of_light(
    source: Source,
    frames: ExposedFrames,
    cd_m2_per_unit: float,
    sensor: Sensor,
    camera: Camera,
    exposure: Exposure,
    recorded: Camera,
) -> dict[str, str]:
    """Reasons why the light is too noisy, or clipped, for a candidate: a word or two -> a sentence."""
    reasons = {}
    light = source.light(frames.name, 0, frames.exposure_ms)
    levels = np.quantile(light, _QUANTILES, axis=(0, 1)).astype(np.float32).reshape(1, 1, len(_QUANTILES), -1)
    gathered = max((recorded.focal_length_px / camera.focal_length_px) ** 2, 1.0)  # recorded pixels in one
    at_levels = np.maximum(levels, 1e-6)
    noise = source.variance_of_levels(frames.name, at_levels) / gathered
    seen = np.broadcast_to(at_levels * cd_m2_per_unit, (1, 1, len(_QUANTILES), 3)).astype(np.float32)
    expected = sensor.expect(seen, camera=camera, exposure=exposure)
    variance = np.asarray(sensor.moments(expected, camera=camera, exposure=exposure)[1]) + 1 / 12
    one = sensor.expect(seen + 1, camera=camera, exposure=exposure) - expected
    carried = one**2 * noise.mean(-1, keepdims=True) * cd_m2_per_unit**2
    ratio = np.sqrt(carried / variance).mean(-1).ravel()
    below_white = expected.mean(-1).ravel() < sensor.white_level_dn
    if below_white.any() and np.median(ratio[below_white]) > 1:
        worst = float(np.median(ratio[below_white]))
        reasons["less noise"] = f"the recording carries {worst:.1f} times the noise of camera {camera.name}"
    top = np.full((1, 1, 1, 3), source.top_dn / frames.exposure_ms * cd_m2_per_unit, np.float32)
    clipped = source.clipped(frames.name)
    if (
        clipped > _CLIPPED
        and float(sensor.expect(top, camera=camera, exposure=exposure).max()) < sensor.white_level_dn
    ):
        reasons["highlights"] = (
            f"{clipped:.0%} of the recording is clipped, which camera {camera.name} would show"
        )
    return reasons
