"""Shares of saturated and of nearly black pixels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.camera import Exposed, exposed, mean_exposed


@given(
    bright=st.integers(0, 40),
    dark=st.integers(0, 40),
    black=st.integers(0, 100),
    bits=st.sampled_from([8, 12]),
)
def test_shares_are_those_that_were_put_there(bright: int, dark: int, black: int, bits: int) -> None:
    white = 2**bits - 1
    frame = np.full((10, 10, 3), (black + white) // 2, np.uint16)
    pixels = frame.reshape(-1, 3)
    pixels[:bright, 1] = white  # one channel is enough
    pixels[bright : bright + dark] = black
    assert exposed(frame, black, white) == pytest.approx((bright / 100, dark / 100))


def test_what_to_change_is_said_once_much_is_lost() -> None:
    assert Exposed(0.05, 0.5).doubt == ""
    assert Exposed(0.31, 0.0).doubt.startswith("31% of pixels are saturated: shorten exposure_ms")
    assert Exposed(0.0, 0.9).doubt.startswith("90% of pixels are nearly black: lengthen exposure_ms")


def test_a_mean_is_that_of_each_share() -> None:
    assert mean_exposed([Exposed(0.0, 1.0), Exposed(0.5, 0.0)]) == Exposed(0.25, 0.5)
