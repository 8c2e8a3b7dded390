"""What the shipped exposure controls aim for, and how they get there."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tacos_framework.values import Exposure, ImageContext
from tacos_plugins.controls.gradient import Gradient, gradient_information
from tacos_plugins.controls.limits import ExposureLimits
from tacos_plugins.controls.mean_level import MeanLevel

TEXTURE = np.random.default_rng(3).uniform(0.2, 1.0, (48, 64, 1))


def frames_of(control, light, count):
    """Levels of a linear camera, full at 1, before a still texture: (exposure, mean) frame by frame."""
    exposure, memory = Exposure(0.010), {}
    for _ in range(count):
        signal = TEXTURE * light * exposure.time_s * exposure.gain
        frame = np.rint(np.clip(signal, 0, 1) * 255).astype(np.uint8)
        yield exposure, frame.mean() / 255
        exposure = control.adjust(frame, exposure=exposure, context=ImageContext(memory=memory))


@given(st.floats(1e-6, 1e3), st.floats(1, 30), st.floats(0, 30))
def test_time_is_spent_before_gain_and_limits_hold(signal_s, longest_ms, highest_gain_db):
    limits = ExposureLimits(longest_ms=longest_ms, highest_gain_db=highest_gain_db)
    chosen = limits.exposure(signal_s, 2.8)
    assert 0.05e-3 <= chosen.time_s <= longest_ms * 1e-3
    assert 0 <= chosen.gain_db <= highest_gain_db
    if chosen.gain_db > 1e-9:
        assert chosen.time_s == pytest.approx(longest_ms * 1e-3)
    within = 0.05e-3 <= signal_s <= longest_ms * 1e-3 * 10 ** (highest_gain_db / 20)
    if within:
        assert chosen.time_s * chosen.gain == pytest.approx(signal_s)


@pytest.mark.parametrize("field", ["shortest_ms", "lowest_gain_db"])
def test_limits_that_fall_are_refused(field):
    with pytest.raises(ValidationError, match=f"{field} is 50"):
        ExposureLimits(**{field: 50.0, "longest_ms": 10, "highest_gain_db": 20})


def test_mean_level_comes_to_its_target_and_follows_with_its_lag():
    control = MeanLevel(MeanLevel.Config(target=0.3, lag_frames=4, longest_ms=1000))
    taken = list(frames_of(control, light=5.0, count=40))
    assert taken[-1][1] == pytest.approx(0.3, rel=0.02)
    stops = [math.log2(0.3 / mean) for _, mean in taken[:6]]
    assert stops[4] == pytest.approx(stops[0] * math.exp(-1), rel=0.05)  # 37 % is left after the lag


def test_a_full_image_is_brought_down_in_the_end():
    control = MeanLevel(MeanLevel.Config(target=0.2, lag_frames=1, shortest_ms=0.01))
    *_, (_, mean) = frames_of(control, light=1e4, count=40)
    assert mean == pytest.approx(0.2, rel=0.05)


def test_gradient_seeks_the_exposure_with_most_gradients():
    """Powers only stand for exposures; what it settles at still has 80 % of the best of many exposures."""
    control = Gradient(Gradient.Config(longest_ms=1000, metered_px=64))

    def information(exposure_s):
        image = np.clip(TEXTURE[..., 0] * 20 * exposure_s, 0, 1).astype(np.float32)
        return gradient_information(image, 0.03, 1000.0)

    *_, (settled, _) = frames_of(control, light=20.0, count=60)
    best = max(map(information, np.geomspace(0.001, 1.0, 200)))
    assert information(0.001) < 0.1 * best
    assert information(settled.time_s * settled.gain) >= 0.8 * best


def test_a_bright_window_does_not_darken_what_a_gradient_control_sees():
    scene = TEXTURE.copy()
    scene[:, :20] = 40.0  # a window, full at any useful exposure
    chosen = {}
    for control in (Gradient(Gradient.Config()), MeanLevel(MeanLevel.Config(target=0.2))):
        exposure, memory = Exposure(0.010), {}
        for _ in range(60):
            frame = np.rint(np.clip(scene * 20 * exposure.time_s * exposure.gain, 0, 1) * 255)
            exposure = control.adjust(
                frame.astype(np.uint8), exposure=exposure, context=ImageContext(memory=memory)
            )
        chosen[type(control)] = exposure.time_s * exposure.gain
    assert chosen[Gradient] > 2 * chosen[MeanLevel]
