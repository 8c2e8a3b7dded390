"""The kernel of an even disc, against discs of many points and the textbook's transfer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import j1

from tacos_plugins.effects.disc import covered_shares, disc_kernel

RADII_PX = st.floats(0.01, 40.0)


def offsets(kernel):
    return np.arange(len(kernel)) - len(kernel) // 2


def transfer(kernel, frequency, angle_deg):
    x, angle = offsets(kernel), np.radians(angle_deg)
    phase = 2 * np.pi * frequency * (x[None, :] * np.cos(angle) + x[:, None] * np.sin(angle))
    return float((kernel * np.cos(phase)).sum())


@given(RADII_PX)
@settings(max_examples=100, deadline=None)
def test_it_is_a_spread_of_light_with_the_variance_of_the_disc(radius_px):
    kernel = disc_kernel(radius_px)
    assert kernel.min() >= 0
    assert kernel.sum() == pytest.approx(1.0, abs=1e-12)
    for axis in (0, 1):
        assert kernel.sum(axis=axis) @ offsets(kernel) ** 2 == pytest.approx(radius_px**2 / 4, rel=1e-6)


@given(RADII_PX)
@settings(max_examples=50, deadline=None)
def test_it_is_the_same_from_all_eight_sides_and_no_wider_than_the_disc(radius_px):
    kernel = disc_kernel(radius_px)
    np.testing.assert_allclose(kernel, kernel.T, atol=1e-12)
    np.testing.assert_allclose(kernel, kernel[::-1], atol=1e-12)
    assert len(kernel) // 2 <= np.ceil(radius_px)


@given(st.floats(0.5, 12.0))
@settings(max_examples=40, deadline=None)
def test_shares_are_those_of_a_disc_of_many_points(radius_px):
    fine = 40
    shares = covered_shares(radius_px)
    half = len(shares) // 2
    at = (np.arange((2 * half + 1) * fine) + 0.5) / fine - half - 0.5
    inside = (np.hypot(at[None, :], at[:, None]) < radius_px).astype(np.float64)
    counted = inside.reshape(2 * half + 1, fine, 2 * half + 1, fine).mean((1, 3))
    np.testing.assert_allclose(shares, counted / counted.sum(), atol=0.03 / (np.pi * radius_px**2))


@given(st.floats(0.05, 20.0), st.sampled_from([0.0, 20.0, 45.0]))
@settings(max_examples=60, deadline=None)
def test_its_transfer_is_that_of_the_disc_and_falls_from_one(radius_px, angle_deg):
    kernel = disc_kernel(radius_px)
    frequencies = np.linspace(0.005, 0.125, 13)
    found = np.array([transfer(kernel, frequency, angle_deg) for frequency in frequencies])
    z = 2 * np.pi * radius_px * frequencies
    np.testing.assert_allclose(found, 2 * j1(z) / z, atol=0.01)
    main_lobe = z < 3.5  # the first zero is at 3.83
    assert np.all(np.diff([1.0, *found[main_lobe]]) < 0)


@given(st.floats(0.02, 20.0), st.floats(1.001, 1.02))
@settings(max_examples=60, deadline=None)
def test_it_changes_smoothly_with_its_radius(radius_px, factor):
    """A fit of the radius has something to go by."""
    one, other = disc_kernel(radius_px), disc_kernel(radius_px * factor)
    wider = len(other) // 2 - len(one) // 2
    difference = np.abs(np.pad(one, wider) - other).sum()
    assert 0 < difference < 6 * (factor - 1)
