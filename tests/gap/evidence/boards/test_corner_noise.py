"""The noise of corners is that of the views, whatever lens and paper."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_gap.evidence.boards.corner_noise import smooth_residual, steadied
from tests.gap.evidence.boards.drawn_boards import CENTRE, SQUARES, points, pose, seen

LENSES = {
    "pinhole": (536.0, {}),
    "barrel": (536.0, {"brown": (-0.3, 0.05, 0, 0, 0)}),
    "fisheye": (280.0, {"fisheye": (0.02, 0, 0, 0)}),
}


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize("noise_px", [0.03, 0.2])
def test_noise_is_told_from_lens_pose_and_paper(lens, noise_px):
    focal_px, settings = LENSES[lens]
    rng = np.random.default_rng(5)
    printed = points(SQUARES)
    sagging = printed + np.array([0, 0, 1]) * (((printed[:, :1] - 100) / 100) ** 2)
    found = []
    for tilt in ((0, 0), (25, 10), (-20, 30)):
        where = seen(*pose(tilt, 0.62 * focal_px, printed.mean(axis=0)), sagging, focal_px, **settings)
        found.append(smooth_residual(printed, where + rng.normal(0, noise_px, where.shape), CENTRE)[1])
    assert np.median(found) == pytest.approx(noise_px, rel=0.3, abs=0.03)


def test_a_stray_corner_stands_out_and_does_not_count():
    rng = np.random.default_rng(6)
    printed = points(SQUARES)
    where = seen(*pose((20, 10), 330.0, printed.mean(axis=0)), printed, 536.0)
    where = where + rng.normal(0, 0.05, where.shape)
    where[17] += [4.0, -3.0]
    residual_px, noise_px = smooth_residual(printed, where, CENTRE)
    assert np.argmax(np.hypot(*residual_px.T)) == 17
    assert noise_px < 0.1


def test_a_view_that_seems_perfect_by_luck_is_not_believed():
    assert steadied([0.05, 0.06, 0.001]) == pytest.approx([0.05, 0.06, 0.03])
    assert steadied([]) == []
