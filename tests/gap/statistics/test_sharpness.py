"""Contrast of detail is compared where detail is expected, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tacos_gap.captures import Noise
from tacos_gap.captures.large import part_of
from tacos_gap.statistics import Sample, StatisticBlock, measure
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture

ANGLE_DEG = 84.0
"""Of the normal of the edge, from the columns."""


def edge(finer: int = 8) -> np.ndarray:
    """(H, W) a slanted edge, drawn in finer pixels and averaged [DN above the pedestal]."""
    y, x = np.mgrid[: HEIGHT * finer, : WIDTH * finer] / finer
    turned = (x - WIDTH / 2) * np.cos(np.radians(ANGLE_DEG)) + (y - HEIGHT / 2) * np.sin(
        np.radians(ANGLE_DEG)
    )
    fine = np.where(turned > 0, 150.0, 30.0).astype(np.float32)
    return cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)


def detail(variance_dn2: float, sigma_px: float = 0.0, seed: int = 1) -> StatisticBlock:
    """That of a picture of the edge, blurred before its noise."""
    expected = edge() + BLACK_DN
    of = capture("edge", "edge", expected, frames=1)
    of = replace(of, noise=Noise((0.0,), (variance_dn2,)))
    blurred = cv2.GaussianBlur(expected, (0, 0), sigma_px) if sigma_px else expected
    noise = np.random.default_rng(seed).normal(0, np.sqrt(variance_dn2), expected.shape)
    frames = (blurred + noise).astype(np.float32)[None, :, :, None]
    assert of.expected_dn is not None
    (found,) = (b for b in measure(Sample(of, frames, of.expected_dn)) if b.statistic == "detail")
    return found


@pytest.mark.parametrize("variance_dn2", [0.5, 4.0])
def test_an_edge_tells_of_detail_across_itself_alone(variance_dn2):
    found = detail(variance_dn2)
    fine = [at for at in found.at if at["frequency_cycles_px"][0] > 0.03]
    assert fine
    assert {at["direction_deg"] for at in fine} == {90}


def test_more_noise_leaves_fewer_cells_and_no_difference_in_them():
    few, many = detail(60.0), detail(0.5)
    assert len(few.values) < len(many.values)
    assert np.abs(few.values).max() < 0.5
    assert np.abs(many.values).max() < 0.1


def test_cells_show_the_transfer_of_a_gaussian():
    """exp(-4 pi^2 sigma^2 f^2) of the power, averaged over a band; where noise is faint."""
    sigma_px = 0.8
    found = detail(0.05, sigma_px)
    for at, value in zip(found.at, found.values, strict=True):
        low, high = at["frequency_cycles_px"]
        if at["direction_deg"] == 90 and high < 0.3:
            ends = [-4 * (np.pi * sigma_px * f) ** 2 for f in (high, low)]
            assert ends[0] < value < ends[1] + 0.02


@pytest.mark.parametrize(("rows", "columns"), [(48, 60), (40, 90), (63, 63)])
def test_a_small_region_of_interest_tells_of_detail(rows, columns):
    """Of an edge blurred by .8 px the finest band loses what a Gaussian takes from it."""
    sigma_px, expected = 0.8, edge() + BLACK_DN
    part = slice(HEIGHT // 2 - rows // 2, HEIGHT // 2 - rows // 2 + rows), slice(0, columns)
    whole = replace(capture("roi", "edge", expected, 1), noise=Noise((0.0,), (0.05,)))
    of = part_of(whole, part)
    blurred = cv2.GaussianBlur(expected, (0, 0), sigma_px)[part][None, :, :, None]
    assert of.expected_dn is not None
    (found,) = (b for b in measure(Sample(of, blurred, of.expected_dn)) if b.statistic == "detail")
    for value, at in zip(found.values, found.at, strict=True):
        low, high = at["frequency_cycles_px"]
        most, least = (-((2 * np.pi * sigma_px * f) ** 2) for f in (low, high))
        assert least - 0.1 < value < most + 0.1
