"""Demosaicing, against OpenCV's and against formulas written out pixel by pixel."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tacos_framework.values import ContextMissing
from tacos_plugins.effects.demosaic import Demosaic
from tacos_plugins.effects.mosaic import METHODS, mosaic, mosaic_channels
from tests.effects.sample_arrays import flats, make, run

PATTERNS = ("RGGB", "GRBG", "GBRG", "BGGR")
TO_RGB = {  # OpenCV names a pattern by its second row's second and third photosites
    "RGGB": (cv2.COLOR_BayerBG2RGB, cv2.COLOR_BayerBG2RGB_EA),
    "GRBG": (cv2.COLOR_BayerGB2RGB, cv2.COLOR_BayerGB2RGB_EA),
    "GBRG": (cv2.COLOR_BayerGR2RGB, cv2.COLOR_BayerGR2RGB_EA),
    "BGGR": (cv2.COLOR_BayerRG2RGB, cv2.COLOR_BayerRG2RGB_EA),
}
SCENE = np.random.default_rng(1).integers(0, 256, (1, 24, 30, 3)).astype(np.float64)
INSIDE = np.s_[3:-3, 3:-3]
every_method = pytest.mark.parametrize("method", METHODS)
every_pattern = pytest.mark.parametrize("cfa", PATTERNS)


@every_pattern
def test_bilinear_agrees_with_opencv_to_its_rounding(cfa):
    plane = mosaic(SCENE[0], cfa)
    theirs = cv2.cvtColor(plane.astype(np.uint8), TO_RGB[cfa][0]).astype(float)
    ours = run(make(Demosaic, method="bilinear", cfa=cfa), SCENE)[0]
    assert np.abs(ours - theirs)[INSIDE].max() <= 0.5


def test_gradient_correction_is_malvars_formula_at_each_kind_of_photosite():
    cfa = "RGGB"
    p = mosaic(SCENE[0], cfa)
    full = run(make(Demosaic, method="gradient-corrected", cfa=cfa), SCENE)[0]

    def around(y, x, *offsets):
        return sum(p[y + dy, x + dx] for dy, dx in offsets)

    near = ((0, 1), (0, -1), (1, 0), (-1, 0))
    far = ((0, 2), (0, -2), (2, 0), (-2, 0))
    corners = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    y, x = 8, 10  # red
    assert full[y, x, 1] == pytest.approx((4 * p[y, x] + 2 * around(y, x, *near) - around(y, x, *far)) / 8)
    assert full[y, x, 2] == pytest.approx(
        (6 * p[y, x] + 2 * around(y, x, *corners) - 1.5 * around(y, x, *far)) / 8
    )
    y, x = 8, 11  # green in a red row
    red = (
        5 * p[y, x]
        + 4 * around(y, x, (0, 1), (0, -1))
        - around(y, x, (0, 2), (0, -2), *corners)
        + 0.5 * around(y, x, (2, 0), (-2, 0))
    ) / 8
    assert full[y, x, 0] == pytest.approx(red)


@every_method
@every_pattern
def test_samples_that_were_taken_are_kept_and_flats_stay_flat(method, cfa):
    full = run(make(Demosaic, method=method, cfa=cfa), SCENE)[0]
    channels = mosaic_channels(cfa, *full.shape[:2])
    kept = np.take_along_axis(full, channels[..., None], axis=-1)[..., 0]
    np.testing.assert_allclose(kept, mosaic(SCENE[0], cfa))
    colours = np.broadcast_to([90.0, 120.0, 60.0], SCENE.shape).copy()
    np.testing.assert_allclose(run(make(Demosaic, method=method, cfa=cfa), colours), colours, atol=1e-9)


@pytest.mark.parametrize("turned", [False, True])
def test_edge_aware_draws_no_zip_along_a_grey_edge(turned):
    edge = np.full((24, 30), 50.0)
    edge[:, 15:] = 200.0
    grey = np.repeat((edge.T if turned else edge)[None, ..., None], 3, axis=-1)
    false_colour = {m: np.ptp(run(make(Demosaic, method=m), grey), axis=-1).max() for m in METHODS}
    assert false_colour["edge-aware"] < 0.3 * false_colour["bilinear"]


def test_interpolated_samples_have_the_variance_of_a_mean_in_a_lattice_of_period_two():
    noisy = flats(100.0, 3.0, frames=1, height=400, width=400)
    full = run(make(Demosaic, method="bilinear", cfa="RGGB"), noisy)[0]
    red = full[..., 0]
    variance = [red[y::2, x::2].var() / 9 for y in (0, 1) for x in (0, 1)]
    np.testing.assert_allclose(variance, [1, 1 / 2, 1 / 2, 1 / 4], rtol=0.04)  # 40,000 each: error 0.7 %


def test_demosaicing_needs_colour():
    with pytest.raises(ContextMissing, match="in colour"):
        run(make(Demosaic, method="bilinear"), flats(channels=1))


def test_filters_that_are_no_bayer_mosaic_are_refused():
    with pytest.raises(ValueError, match="two G, one R and one B"):
        mosaic_channels("RGBW", 4, 4)
