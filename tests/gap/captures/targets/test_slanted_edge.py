"""Slanted edges: the line, the response, and the sharp edge they would be."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import erf

from tacos_gap.captures.targets.slanted_edge import (
    edge_spread,
    find_edge,
    mtf50_cycles_px,
    overshoot,
    sharp_edge,
)

DATA = Path(__file__).parents[5] / "shared" / "data" / "real"


def edge(angle_deg: float, sigma_px: float, shape=(120, 140)) -> np.ndarray:
    """A Gaussian edge by its closed form, dark on the left where it stands upright."""
    y, x = np.mgrid[: shape[0], : shape[1]]
    turn = np.radians(angle_deg)
    distance = np.cos(turn) * (x - shape[1] / 2) + np.sin(turn) * (y - shape[0] / 2)
    return 40 + 150 * (1 + erf(distance / (sigma_px * np.sqrt(2)))) / 2


@settings(max_examples=25, deadline=None)
@given(
    st.floats(3, 8).flatmap(
        lambda angle: st.sampled_from([angle, -angle, 90 + angle, 180 - angle, 270 + angle])
    ),
    st.floats(0.5, 1.6),
)
@example(np.degrees(np.arctan(1 / 8)), 1.0)  # pixels lie at eight distances, and in few bins at the middle
def test_the_response_of_a_gaussian_edge_is_gaussian(angle_deg, sigma_px):
    image = edge(angle_deg, sigma_px)
    found = find_edge(image)
    assert found is not None
    half = np.sqrt(np.log(2) / (2 * np.pi**2)) / sigma_px
    assert mtf50_cycles_px(image, found) == pytest.approx(half, rel=0.05)
    assert overshoot(image, found) < 0.01
    assert np.dot(found.normal, [np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))]) > 0.9999


def test_the_sharp_edge_has_the_two_sides_and_the_place_of_the_blurred_one():
    image = edge(5, 1.5)
    sharp, near = sharp_edge(image, find_edge(image))
    assert near.all()
    assert sharp.min() == pytest.approx(40, abs=0.1)
    assert sharp.max() == pytest.approx(190, abs=0.1)
    assert np.abs(sharp - edge(5, 0.25)).mean() < 0.2


def test_a_sharpened_edge_goes_beyond_its_sides():
    image = edge(5, 1.0)
    sharpened = 1.8 * image - 0.8 * cv2.GaussianBlur(image, (0, 0), 2.0)
    assert overshoot(sharpened, find_edge(sharpened)) > 0.1
    places, levels = edge_spread(sharpened, find_edge(sharpened))
    assert levels[places < -16].mean() == pytest.approx(0, abs=0.01)


def test_what_is_no_single_straight_edge_is_none():
    noise = np.random.default_rng(0).normal(100, 3, (120, 140))
    bars = edge(5, 1.0) - np.roll(edge(5, 1.0), 40, axis=1)
    y, x = np.mgrid[:120, :140]
    disc = np.where(np.hypot(x - 70, y - 60) < 40, 200.0, 50.0)
    assert [find_edge(each) for each in (noise, bars, disc, np.full((120, 140), 9.0))] == [None] * 4


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")
def test_the_edge_of_a_real_scan():
    image = cv2.imread(str(DATA / "slanted_edge/Test_edge1_mono.tif"), cv2.IMREAD_UNCHANGED)
    found = find_edge(image)
    assert mtf50_cycles_px(image, found) == pytest.approx(0.293, abs=0.006)  # by its publisher


@pytest.mark.parametrize("fall_off", [0.0, 0.35])
def test_light_that_falls_off_moves_no_edge(fall_off):
    y, x = np.mgrid[:240, :320]
    radius2 = ((x - 159.5) ** 2 + (y - 119.5) ** 2) / (159.5**2 + 119.5**2)
    distance = (x - 190) * np.cos(np.radians(6)) + (y - 119.5) * np.sin(np.radians(6))
    sharp = 20 + 150 * 0.5 * (1 + erf(distance / np.sqrt(2) / 1.3))
    edge = find_edge(sharp * (1 - fall_off * radius2))
    assert edge is not None
    assert np.abs(edge.distance_px(sharp.shape) - distance).max() < 0.06
