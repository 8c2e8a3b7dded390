"""Targets whose bars are too narrow for noise to be measured on them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.errors import UserError
from tacos_plugins.noise_calibration.frame_files import FrameStack
from tacos_plugins.noise_calibration.measuring import measure


def stack(bar_px: int, sigma_dn: float, seed: int) -> FrameStack:
    rng = np.random.default_rng(seed)
    bars = np.tile(np.repeat(rng.permutation(np.linspace(300, 3500, 16)), bar_px), (96, 1))
    frames = np.stack([np.rint(bars + sigma_dn * rng.standard_normal(bars.shape)) for _ in range(6)])
    return FrameStack({"mono": [frames.astype(np.uint16)]}, "frames")


def said_of(frames: FrameStack) -> str:
    with pytest.raises(UserError) as refused:
        measure(frames, black_level_dn=64, white_level_dn=4095, levels=12)
    return str(refused.value)


@settings(max_examples=15, deadline=None)
@given(bar_px=st.integers(2, 8), sigma_dn=st.floats(2, 20), seed=st.integers(0, 99))
def test_narrow_bars_are_never_called_equal_frames(bar_px: int, sigma_dn: float, seed: int) -> None:
    said = said_of(stack(bar_px, sigma_dn, seed))
    assert "all frames are the same" not in said
    assert "bars of 20 px or more" in said or "each of some hundred pixels" in said


def test_copies_of_one_frame_are_called_that() -> None:
    frames = stack(40, 5.0, 0)
    (planes,) = frames.planes["mono"]
    copies = np.repeat(planes[:1], 6, axis=0)
    assert "all frames are the same" in said_of(FrameStack({"mono": [copies]}, "frames"))
