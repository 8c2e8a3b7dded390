"""Pictures that are shifted, magnified and out of focus against what is expected of them."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_plugins.effects import alignment
from tacos_plugins.effects.alignment import aligned, aligned_with_expected
from tacos_plugins.effects.focal_length_error import FocalLengthError
from tests.gap.small_captures import BLACK_DN, capture

HEIGHT, WIDTH = 240, 320
CENTRE = ((WIDTH - 1) / 2, (HEIGHT - 1) / 2)


def rectangles() -> NDArray[np.float32]:
    """(H, W) rectangles of all sizes one over the other, in [0, 1]."""
    rng = np.random.default_rng(4)
    image = np.full((HEIGHT, WIDTH), 0.4, np.float32)
    for _ in range(80):
        x, y, w, h = (int(v) for v in rng.integers((0, 0, 8, 8), (WIDTH, HEIGHT, 70, 70)))
        image[y : y + h, x : x + w] = rng.uniform(0.05, 0.95)
    return image


def seen(scale: float, dx_px: float, dy_px: float, disc_px: float = 0.0) -> NDArray[np.float32]:
    """The rectangles magnified about the middle, moved and out of focus, by OpenCV."""
    x, y = CENTRE
    matrix = np.array([[scale, 0, x - scale * x + dx_px], [0, scale, y - scale * y + dy_px]])
    moved = cv2.warpAffine(rectangles(), matrix, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REFLECT)
    if disc_px:
        rows, columns = np.mgrid[-12:13, -12:13]
        disc = (np.hypot(rows, columns) <= disc_px).astype(np.float32)
        moved = cv2.filter2D(moved, -1, disc / disc.sum())
    return np.asarray(moved, np.float32)


@given(st.floats(0.98, 1.02), st.floats(-6, 6), st.floats(-6, 6), st.sampled_from([0.0, 3.0, 8.0]))
@settings(max_examples=15, deadline=None)
def test_a_picture_far_off_and_out_of_focus_is_aligned(scale, dx_px, dy_px, disc_px):
    matrix = aligned(rectangles(), seen(scale, dx_px, dy_px, disc_px))
    assert matrix is not None
    assert (matrix[0, 0] + matrix[1, 1]) / 2 == pytest.approx(scale, abs=0.002)
    assert matrix @ [*CENTRE, 1] - CENTRE == pytest.approx([dx_px, dy_px], abs=0.3)


def test_what_shows_something_else_is_not_aligned():
    noise = np.random.default_rng(0).uniform(size=(HEIGHT, WIDTH)).astype(np.float32)
    assert aligned(rectangles(), noise) is None
    assert aligned(rectangles()[:20, :20], rectangles()[:20, :20]) is None


def scene(scale: float, dx_px: float, dy_px: float) -> RealCapture:
    x, y, width, height = 60, 50, 160, 120  # what test captures are large
    view = slice(y, y + height), slice(x, x + width)
    believed = capture("scene", "scene", BLACK_DN + 200 * rectangles()[view])
    real = BLACK_DN + 200 * seen(scale, dx_px, dy_px)[view]
    return replace(believed, real_dn=np.repeat(real[None, ..., None], 2, axis=0))


def test_a_focal_length_error_begins_at_how_scenes_align():
    (guess,) = FocalLengthError.guesses_from([scene(1.0, 3.0, -2.0)])
    assert guess["scale"] == pytest.approx(1.0, abs=0.003)
    assert (guess["dx_px"], guess["dy_px"]) == pytest.approx((3.0, -2.0), abs=0.2)


def test_scenes_that_stand_where_they_should_suggest_no_focal_length():
    assert list(FocalLengthError.guesses_from([scene(1.0, 0.2, 0.0)])) == []


def test_an_edge_alone_aligns_with_no_squeezed_picture():
    """Along an edge any map correlates: one that stretches the picture by two and a half is no view of it."""
    rows, columns = np.mgrid[:120, :160].astype(np.float32)
    across = (columns - 48) * np.cos(0.1) + (rows - 60) * np.sin(0.1)
    edges = [1 / (1 + np.exp(-(across - off) / 3)) for off in (0.0, 10.0)]
    noise = np.random.default_rng(1).normal(0, 0.01, (2, 120, 160))
    found = aligned(*(np.asarray(e + n, np.float32) for e, n in zip(edges, noise, strict=True)))
    assert found is None or np.linalg.svd(found[:, :2], compute_uv=False) == pytest.approx([1, 1], abs=0.5)


def test_a_capture_is_aligned_once(monkeypatch):
    expected, real = (BLACK_DN + 200 * picture for picture in (rectangles(), seen(1.01, 1.5, -0.5)))
    of = replace(
        capture("scene", "scene", 0.0),
        expected_dn=expected[None, :, :, None],
        real_dn=real[None, :, :, None],
        valid=np.ones((HEIGHT, WIDTH), bool),
    )
    first = aligned_with_expected(of)
    assert first is not None
    monkeypatch.setattr(alignment, "aligned", lambda *args: pytest.fail("aligned again"))
    np.testing.assert_array_equal(aligned_with_expected(of), first)
