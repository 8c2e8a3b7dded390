"""Where samples of a colour are clipped, by the pile that they form."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tacos_worlds.recorded.recording import ExposedFrames, Recording
from tacos_worlds.recorded.response import Response, linear_response
from tacos_worlds.recorded.saturation import clipping_codes, trusted_codes


def forest(rng: np.random.Generator) -> NDArray[np.float64]:
    """Light of a scene over 1 as white, some of it beyond."""
    return np.exp(rng.normal(-1.2, 0.8, (4, 240, 320)))


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
def test_each_colour_is_clipped_where_its_own_samples_pile_up(bits: int) -> None:
    rng = np.random.default_rng(1)
    white = (1 << bits) - 1
    full = np.tile([[1.0, 0.92], [0.92, 1.0]], (120, 160))
    light = np.minimum(forest(rng), full * (1 + 0.003 * rng.normal(size=full.shape)))
    found = clipping_codes(np.clip(light * white, 0, white).astype(np.uint16), white) / white
    assert found[0, 1] == pytest.approx(0.91, abs=0.01)
    assert found[1, 0] == found[0, 1]
    assert min(found[0, 0], found[1, 1]) > 0.98


def test_a_bright_sky_is_no_pile() -> None:
    rng = np.random.default_rng(2)
    light = np.minimum(forest(rng), 0.6)
    light[:, :80] = 0.85 * (1 + 0.04 * rng.normal(size=(4, 80, 320)))
    codes = np.clip(light * 4095, 0, 4095).astype(np.uint16)
    assert (clipping_codes(codes, 4095) >= 4080).all()


def test_white_paper_is_no_pile() -> None:
    rng = np.random.default_rng(5)
    light = np.minimum(forest(rng), 0.85)
    light[:, :80] = 0.87 * (1 + 0.005 * rng.normal(size=(4, 80, 320)))  # the noise of 40,000 electrons
    codes = np.clip(light * 4095, 0, 4095).astype(np.uint16)
    assert (clipping_codes(codes, 4095) == 4095).all()


def test_nothing_is_clipped_in_frames_that_reach_nowhere() -> None:
    codes = np.random.default_rng(3).integers(0, 900, (2, 64, 64)).astype(np.uint16)
    assert (clipping_codes(codes, 4095) == 4095).all()


def test_codes_are_trusted_as_far_as_exposures_agree() -> None:
    light = forest(np.random.default_rng(4)) * 1500
    frames = {t: np.clip(light * t, 0, 4095).astype(np.uint16) for t in (0.5, 1.0, 2.0)}
    clipping = np.full((2, 2), 4095)
    assert (trusted_codes(frames, linear_response(4095), clipping) == 4095).all()
    too_bright_above = 3000
    wrong = Response(np.array([0.0, too_bright_above, 4095]), np.array([0.0, too_bright_above, 6500]))
    found = trusted_codes(frames, wrong, clipping)
    truth = np.interp(found, wrong.code_dn, wrong.light_dn) / found
    assert truth == pytest.approx(1.15, abs=0.06)


def test_a_response_that_exposures_contradict_moves_no_clipping() -> None:
    light = forest(np.random.default_rng(4)) * 1500
    exposures = {
        f"{t:g}": ExposedFrames(t, np.arange(4.0), np.clip(light * t, 0, 4095).astype(np.uint16))
        for t in (0.5, 1.0, 2.0)
    }
    wrong = Response(np.array([0.0, 3000, 4095]), np.array([0.0, 3000, 6500]))
    recording = Recording(exposures, 12, wrong, "made up", np.full((2, 2), 4095))
    assert recording.clipping_dn == pytest.approx(6500, rel=0.01)
    assert recording.top_dn < 4500
