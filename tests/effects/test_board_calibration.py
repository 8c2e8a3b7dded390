"""Calibrations start the search for a lens; they agree with OpenCV's own projections."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tacos_framework.values import Lens
from tacos_plugins.effects.board_calibration import calibrated
from tacos_plugins.effects.focal_length_error import FocalLengthError
from tacos_plugins.effects.lens_distortion import LensDistortion
from tests.gap.evidence.boards.test_board_diagnosis import FOCAL_PX, VIEWS, views

FREE = ("focal_length", "principal_point")


def test_a_lens_is_calibrated_over_the_believed_focal_length():
    found = calibrated(views(noise_px=0.0, brown=(-0.3, 0.08, 0, 0, 0)))
    assert found is not None
    assert found.radial[:2] == pytest.approx((-0.3, 0.08), abs=2e-3)
    assert found.focal_px == FOCAL_PX
    assert found.rms_px < 0.01


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.5])
def test_an_unknown_focal_length_is_found_from_afar(scale):
    found = calibrated(views(noise_px=0.02, focal_px=scale * FOCAL_PX, brown=(-0.2, 0, 0, 0, 0)), free=FREE)
    assert found is not None
    assert found.focal_px == pytest.approx(FOCAL_PX, rel=5e-3)


def test_a_fisheye_over_a_focal_length_that_is_a_little_off():
    near = [((0, 0), 160.0), ((25, 10), 190.0), ((-20, 25), 180.0), ((15, -30), 190.0)]
    captures = views(noise_px=0.0, poses=near, true_focal_px=280.0, focal_px=282.8, fisheye=(0.02, 0, 0, 0))
    assert calibrated(captures, free=("focal_length",), fisheye=True).radial[0] == pytest.approx(
        0.02, abs=5e-3
    )
    over = calibrated(captures, terms=3, fisheye=True)
    assert over.focal_px == 282.8
    angle = np.linspace(0.1, 0.65, 20)
    true, found = (
        f * angle * (1 + angle**2 * k[0] + angle**4 * k[1] + angle**6 * k[2])
        for f, k in ((280.0, (0.02, 0, 0)), (282.8, over.radial))
    )
    np.testing.assert_allclose(found, true, rtol=0.02)


def test_a_known_fisheye_is_calibrated_beyond_what_it_is_known_for():
    """As it is where a fisheye of another projection is believed, whose own curve counts."""
    near = [(tilt, 0.3 * distance) for tilt, distance in VIEWS]
    captures = views(noise_px=0.0, poses=near, focal_px=280.0, true_focal_px=280.0, fisheye=(0.02, 0, 0, 0))
    for known, beyond in ((Lens("equidistant"), 0.02), (Lens("equisolid"), 0.02 + 1 / 24)):
        believed = [replace(c, geometry=replace(c.geometry, lens=known)) for c in captures]
        assert calibrated(believed, terms=1, fisheye=True).radial == pytest.approx(
            (beyond, 0, 0, 0), abs=2e-3
        )
        assert calibrated(believed) is None


def test_a_calibration_is_the_same_to_the_bit_each_time():
    boards = views(noise_px=0.1, brown=(-0.2, 0.05, 0, 0, 0))
    before = cv2.getNumThreads()
    cv2.setNumThreads(4)
    try:
        found = [calibrated(boards, free=FREE) for _ in range(8)]
        assert cv2.getNumThreads() == 4
    finally:
        cv2.setNumThreads(before)
    assert len({each.focal_px for each in found if each is not None}) == 1


def test_crops_share_a_lens():
    captures = views(noise_px=0.0, brown=(-0.3, 0, 0, 0, 0))
    printed, where = captures[0].corners
    geometry = captures[0].geometry.crop(x=40, y=30, width_px=560, height_px=420)
    captures[0] = replace(captures[0], geometry=geometry, corners=(printed, where - [40, 30]))
    assert calibrated(captures, terms=1).radial[0] == pytest.approx(-0.3, abs=1e-3)


def test_guesses_come_from_boards_alone():
    captures = views(brown=(-0.25, 0, 0, 0, 0), true_focal_px=1.05 * FOCAL_PX)
    lenses = list(LensDistortion.guesses_from(captures))
    assert [sorted(guess) for guess in lenses] == [
        ["k1"],
        ["k1", "k2"],
        ["k1", "k2", "k3"],
        ["k1", "k2", "k3", "model"],
    ]
    scales = [guess["scale"] for guess in FocalLengthError.guesses_from(captures)]
    assert scales[-1] == pytest.approx(1.05, abs=0.01)
    bare = [replace(capture, corners=None) for capture in captures]
    assert list(LensDistortion.guesses_from(bare)) == list(FocalLengthError.guesses_from(bare)) == []


def test_points_look_where_the_map_does():
    geometry = views()[0].geometry
    rows, columns = np.mgrid[5:470:60, 5:630:70].astype(float)
    for effect in (
        LensDistortion(LensDistortion.Config(k1=-0.2, p1=0.003)),
        LensDistortion(LensDistortion.Config(model="fisheye", k1=0.02)),
        LensDistortion(LensDistortion.Config()),
        FocalLengthError(FocalLengthError.Config(scale=1.1, dx_px=3.0)),
    ):
        x, y = effect.source_at(columns.ravel(), rows.ravel(), geometry=geometry)
        places = effect.source(geometry=geometry, context=None, frames=1)
        if places is None:
            np.testing.assert_array_equal((x, y), (columns.ravel(), rows.ravel()))
            continue
        at = rows.astype(int), columns.astype(int)
        np.testing.assert_allclose(x, np.broadcast_to(places[0], (480, 640))[at].ravel(), atol=1e-6)
        np.testing.assert_allclose(y, np.broadcast_to(places[1], (480, 640))[at].ravel(), atol=1e-6)
