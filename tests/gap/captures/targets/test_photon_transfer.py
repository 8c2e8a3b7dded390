"""Noise by pairs of frames, against cameras of numpy's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_gap.captures.capture import Noise
from tacos_gap.captures.noise_estimate import estimate_noise
from tacos_gap.captures.rounding import before_rounding
from tacos_gap.captures.targets.photon_transfer import pooled_noise
from tests.gap.small_captures import capture


def _flat(files, black_dn):
    """A wall of these files."""
    made = capture("wall", "flat", 100.0)
    context = replace(made.context, black_level_dn=black_dn)
    valid = np.ones(files.shape[1:3], bool)
    return replace(made, real_dn=files, expected_dn=None, valid=valid, context=context)


def _files(rng, light_e, *, dn_per_electron, read_e, black_dn, frames=2):
    """(N, H, W, 1) whole numbers of a camera."""
    electrons = rng.poisson(light_e, (frames, *light_e.shape)) + rng.normal(
        0, read_e, (frames, *light_e.shape)
    )
    return np.clip(np.rint(electrons * dn_per_electron + black_dn), 0, 255).astype(np.float32)[..., None]


@pytest.mark.parametrize(("black_dn", "read_e"), [(8.0, 6.0), (8.3, 24.0)])
@pytest.mark.parametrize("dark_side", [0.07, 0.1])
def test_the_line_of_a_camera_is_found_by_a_dark_a_wall_and_an_edge(black_dn, read_e, dark_side):
    """The even side of an edge lies at few codes, whose pairs differ by even numbers alone."""
    rng = np.random.default_rng(1)
    dark, wall = np.zeros((200, 200)), np.full((200, 200), 0.5)
    edge = np.where(np.arange(200)[None] > 100, 0.7, dark_side) * np.ones((200, 1))
    captures = []
    for light in (dark, wall, edge):
        files = _files(rng, 6000 * light, dn_per_electron=0.0425, read_e=read_e, black_dn=black_dn)
        captures.append(_flat(files, black_dn))
    found = pooled_noise(captures)
    assert found is not None
    assert found.photon_dn[0] == pytest.approx(0.0425, rel=0.02)
    assert found.thermal_dn2[0] == pytest.approx((read_e * 0.0425) ** 2, rel=0.1)


def test_a_pedestal_that_nobody_believes_is_no_signal():
    """Darks at 26 DN and a belief of 0: the noise at zero signal is that of the darks."""
    rng = np.random.default_rng(7)
    levels = {"dark": 0.0, "flat": 0.3, "bracket": 0.7}
    captures = [
        replace(
            _flat(
                _files(rng, np.full((200, 200), 6000 * level), dn_per_electron=0.035, read_e=20, black_dn=26),
                0.0,
            ),
            kind=kind,
        )
        for kind, level in levels.items()
    ]
    found = pooled_noise(captures)
    assert found is not None
    assert found.photon_dn[0] == pytest.approx(0.035, rel=0.03)
    assert found.thermal_dn2[0] == pytest.approx((20 * 0.035) ** 2, rel=0.05)


@pytest.mark.parametrize("sigma_dn", [0.26, 0.4, 1.0, 3.0])
@pytest.mark.parametrize("level_dn", [16.0, 16.3, 16.5])
def test_what_rounding_does_is_undone(sigma_dn, level_dn):
    numbers = np.rint(np.random.default_rng(2).normal(level_dn, sigma_dn, 400_000))
    found = before_rounding(numbers.var(), numbers.mean())
    assert found.variance_dn2 == pytest.approx(sigma_dn**2, rel=0.03)


def test_darks_of_few_codes_say_how_they_scatter():
    rng = np.random.default_rng(3)
    files = _files(rng, np.zeros((200, 200)), dn_per_electron=0.0425, read_e=6.0, black_dn=8.0, frames=3)
    found = estimate_noise(_flat(files, 8.0))
    assert isinstance(found, Noise)
    assert found.thermal_dn2[0] == pytest.approx((6 * 0.0425) ** 2, rel=0.1)


def test_a_leaf_that_moves_is_no_noise():
    rng = np.random.default_rng(4)
    light = np.linspace(0.1, 0.8, 200)[None] * np.ones((200, 1))
    files = _files(rng, 6000 * light, dn_per_electron=0.0425, read_e=6.0, black_dn=8.0)
    files[1, :10, :10] += 60
    found = pooled_noise([_flat(files, 8.0)])
    assert found is not None
    assert found.photon_dn[0] == pytest.approx(0.0425, rel=0.03)


@pytest.mark.parametrize("pooled", [True, False])
def test_rows_that_jump_are_no_noise_of_pixels(pooled):
    rng = np.random.default_rng(4)
    captures = []
    for light in (0.0, 0.4, 0.8):
        files = 8 + 0.0425 * rng.poisson(6000 * light, (2, 200, 200)) + rng.normal(0, 0.6, (2, 200, 200))
        files = np.rint(files + rng.normal(0, 0.8, (2, 200, 1)))
        captures.append(_flat(files.astype(np.float32)[..., None], 8.0))
    found = pooled_noise(captures) if pooled else estimate_noise(captures[0])
    assert found is not None
    assert found.thermal_dn2[0] == pytest.approx(0.6**2, rel=0.15)


def test_noise_is_told_through_the_steps_of_a_coarser_converter():
    """Six bits in files of eight: most pairs are alike, and the others differ by four."""
    rng = np.random.default_rng(5)
    captures = []
    for light in (0.0, 0.25, 0.5, 0.8):
        dn = 8 + 0.0425 * rng.poisson(6000 * light, (2, 200, 200)) + rng.normal(0, 1.0, (2, 200, 200))
        codes = np.rint(np.clip(np.rint(dn / 255 * 63), 0, 63) / 63 * 255)
        captures.append(_flat(codes.astype(np.float32)[..., None], 8.0))
    found = pooled_noise(captures)
    assert found is not None
    assert found.photon_dn[0] == pytest.approx(0.0425, rel=0.25)


def test_two_codes_say_nothing_of_noise():
    numbers = np.rint(np.random.default_rng(6).normal(16.4, 0.02, 100_000))
    numbers[:20_000] = 17
    assert before_rounding(numbers.var(), numbers.mean()).steepness < 0.01
    assert before_rounding(1.0, 16.4).steepness == 1.0


@pytest.mark.parametrize("zero_code", [0.2, 0.5])
def test_noise_below_a_code_is_told_by_the_levels_where_it_shows(zero_code):
    """Four bits that are cut off downwards: dim walls lie in two codes, darks in one."""
    rng = np.random.default_rng(8)
    captures = []
    for light in (0.0, 0.12, 0.3, 0.47, 0.66, 0.85):
        electrons = rng.poisson(900 * light, (2, 200, 200)) + rng.normal(0, 3.0, (2, 200, 200))
        codes = np.clip(np.floor(zero_code + electrons / 900 * 16), 0, 15)
        captures.append(replace(_flat((16 * codes).astype(np.float32)[..., None], 0.0), id=str(light)))
    found = pooled_noise(captures)
    assert found is not None
    assert found.photon_dn[0] == pytest.approx(256 / 900, rel=0.08)


@pytest.mark.parametrize("wave", ["sine", "saw"])
def test_a_lamp_that_flickers_over_the_rows_is_no_noise_of_pixels(wave):
    """It ties the level of a row to its difference between frames, so that no bin of levels is spared."""
    rng = np.random.default_rng(5)
    captures = []
    for light in (0.0, 0.3, 0.6, 0.8):
        turns = np.arange(200)[:, np.newaxis] / 53 + rng.random((2, 1, 1))
        lamp = 1 + 0.04 * (np.sin(2 * np.pi * turns) if wave == "sine" else 2 * (turns % 1) - 1)
        electrons = rng.poisson(6000 * light * lamp * np.ones((2, 200, 200))) + rng.normal(
            0, 24, (2, 200, 200)
        )
        captures.append(_flat(np.rint(8 + 0.0425 * electrons).astype(np.float32)[..., None], 8.0))
    found = pooled_noise(captures)
    assert found is not None
    assert found.photon_dn[0] == pytest.approx(0.0425, rel=0.03)
    assert found.thermal_dn2[0] == pytest.approx((24 * 0.0425) ** 2, rel=0.1)
