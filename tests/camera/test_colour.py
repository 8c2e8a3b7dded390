"""Colour against an independent implementation."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tacos_framework.camera.colour import (
    LINEAR_OF_SRGB_BYTE,
    display_image,
    linear_from_srgb,
    luminance,
    srgb_from_linear,
)


def test_encoding_agrees_with_colour_science():
    from colour.models import eotf_inverse_sRGB

    light = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(srgb_from_linear(light), eotf_inverse_sRGB(light), atol=1e-12)


def test_decoding_undoes_encoding():
    code = np.arange(256) / 255
    np.testing.assert_allclose(srgb_from_linear(linear_from_srgb(code)), code, atol=1e-6)
    np.testing.assert_array_equal(LINEAR_OF_SRGB_BYTE, linear_from_srgb(code))


def test_light_outside_the_display_is_clipped():
    np.testing.assert_allclose(srgb_from_linear([-0.1, 1.5]), [0.0, 1.0], atol=1e-12)


def test_luminance_of_grey_is_its_level_and_green_counts_most():
    np.testing.assert_allclose(luminance(np.full((2, 3, 3), 0.4)), np.full((2, 3), 0.4))
    red, green, blue = luminance(np.eye(3))
    assert green > red > blue


@given(st.sampled_from([(0, 255, np.uint8), (64, 4095, np.uint16)]))
def test_a_display_shows_black_to_white(levels):
    black, white, dtype = levels
    ramp = np.arange(white + 1).astype(dtype)
    shown = display_image(ramp, black, white)
    assert shown.dtype == np.uint8
    assert shown[black] == 0
    assert shown[-1] == 255
    assert (np.diff(shown.astype(int)) >= 0).all()
