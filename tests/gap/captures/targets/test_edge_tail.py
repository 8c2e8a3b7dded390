"""A broad tail beside a sharp core is told from every blur of one part."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from skimage.io import imread

from tacos_gap.captures.targets.edge_tail import edge_tail, tails_of
from tacos_gap.captures.targets.slanted_edge import find_edge
from tests.gap.captures.targets.test_slanted_edge import DATA, edge
from tests.gap.captures.test_processing import made

SHAPE = (180, 240)


def blurred(kernel: np.ndarray, noise_dn: float = 1.0) -> np.ndarray:
    """An edge that hardly is blurred, and then by a kernel."""
    sharp = cv2.filter2D(edge(6, 0.5, SHAPE), -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)
    return np.asarray(sharp + np.random.default_rng(4).normal(0, noise_dn, SHAPE))


def disc(radius_px: int) -> np.ndarray:
    y, x = np.mgrid[-radius_px : radius_px + 1, -radius_px : radius_px + 1]
    return (np.hypot(x, y) <= radius_px).astype(float)


@pytest.mark.parametrize("kernel", [np.ones((1, 1)), np.ones((1, 7)), disc(1), disc(3)])
@pytest.mark.parametrize("noise_dn", [0.0, 4.0])
def test_blurs_of_one_part_have_no_tail(kernel, noise_dn):
    image = blurred(kernel, noise_dn)
    assert edge_tail(image, find_edge(image)) is None


@pytest.mark.parametrize("sigma_px", [0.6, 1.0, 1.6])
def test_a_gaussian_of_any_width_has_none(sigma_px):
    image = edge(-7, sigma_px, SHAPE)
    assert edge_tail(image, find_edge(image)) is None


def test_a_veil_around_a_sharp_core_is_measured():
    image = (
        0.8 * edge(6, 0.7, SHAPE) + 0.2 * edge(6, 6.0, SHAPE) + np.random.default_rng(4).normal(0, 1, SHAPE)
    )
    tail = edge_tail(image, find_edge(image))
    assert tail is not None
    assert tail.core_px == pytest.approx(0.75, abs=0.15)
    assert tail.share == pytest.approx(0.2 * 0.55, rel=0.25)  # 3.8 px are .6 of the wide standard deviation
    (said,) = tails_of([made("edge", [image])])
    assert said.startswith("The edge spread has a broad tail: in edge the edge rises within a blur of 0.")
    assert tails_of([made("scene", [image])]) == []


@pytest.mark.skipif(not DATA.is_dir(), reason="real captures are not here")
def test_a_real_edge_has_one():
    (said,) = tails_of([made("edge", [imread(DATA / "slanted_edge" / "Test_edge1_mono.tif").astype(float)])])
    assert "within a blur of 0.8 px, but 5% of its contrast" in said
