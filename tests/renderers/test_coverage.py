"""Blending of edges by what surfaces a pixel sees."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tacos_plugins.renderers.software.coverage import find_edges, seeing_several


def blended(colour, surface):
    copy = np.array(colour, np.float32)
    surface = np.asarray(surface, np.int32)
    as_triangles = np.arange(surface.max() + 1, dtype=np.int32)
    seen = surface[1::2, 1::2].astype(np.float32)
    find_edges(*seeing_several(surface, as_triangles, 0), seen).blend(copy)
    return copy


def seen_at_half_pixels(shape, is_second):
    """Surface 2 where a function of (x, y) in pixels says so, 1 elsewhere."""
    row, column = np.indices((2 * shape[0] + 1, 2 * shape[1] + 1))
    return np.where(is_second((column - 1) / 2, (row - 1) / 2), 2.0, 1.0)


def test_nothing_changes_within_one_surface():
    colour = np.random.default_rng(0).random((5, 7, 3), np.float32)
    np.testing.assert_array_equal(blended(colour, np.ones((11, 15))), colour)


def test_colour_does_not_leak_between_surfaces_of_whole_pixels():
    # The edge lies half-way between pixel centres: a pixel sees the other surface on its border alone.
    surface = seen_at_half_pixels((4, 6), lambda x, y: x > 2.25)
    colour = np.where(surface[1::2, 1::2, None] == 2, [8.0, 4.0, 2.0], 0.0)
    out = blended(colour, surface)
    np.testing.assert_allclose(out[:, 2], [[2.0, 1.0, 0.5]] * 4)
    np.testing.assert_array_equal(out[:, [0, 1, 3, 4, 5]], colour[:, [0, 1, 3, 4, 5]])


def test_a_slanted_edge_covers_what_it_covers():
    surface = seen_at_half_pixels((40, 40), lambda x, y: x > 12.3 + 0.31 * y)
    colour = np.repeat((surface[1::2, 1::2, None] == 2).astype(np.float32), 3, axis=2)
    row = np.arange(40)
    covered = blended(colour, surface)[..., 0].sum(axis=1)
    assert np.abs(covered - (39.5 - (12.3 + 0.31 * row))).max() < 0.3


def test_a_strip_thinner_than_a_pixel_keeps_its_colour_along_its_length():
    # 0.6 px high and slightly slanted: only some pixel centres see it.
    surface = seen_at_half_pixels((9, 24), lambda x, y: np.abs(y - 3.25 - 0.12 * x) < 0.3)
    centres = surface[1::2, 1::2]
    assert 0 < (centres == 2).any(axis=0).mean() < 1
    colour = np.where(centres[..., None] == 2, np.float32(0.0), np.float32(1.0)).repeat(3, axis=2)
    dark = (1 - blended(colour, surface)[..., 0]).sum(axis=0)
    inner = dark[4:-4]
    assert inner.min() > 0.3
    assert inner.max() < 0.9


@given(arrays(np.int32, (7, 9), elements=st.integers(0, 3)))
def test_blended_colours_stay_within_the_range_of_the_colours(surface):
    colour = np.random.default_rng(1).random((3, 4, 3), np.float32)
    out = blended(colour, surface)
    assert out.min() >= colour.min() - 1e-6
    assert out.max() <= colour.max() + 1e-6
