"""Pictures laid over their expectation: what kind of blur they show, by blurs of other packages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageFilter
from scipy import ndimage

from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.pictures import laid_over, share_of_pictures, tile_squares
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.evidence import ImageEvidence
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.inference.presence import BY_PICTURES
from tacos_gap.inference.problem import Problem
from tacos_plugins.effects.defocus import Defocus
from tacos_plugins.effects.focal_length_error import FocalLengthError
from tacos_plugins.effects.lens_blur import LensBlur
from tacos_plugins.effects.lens_distortion import LensDistortion
from tacos_plugins.effects.motion_blur import MotionBlur
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture
from tests.gap.taken import patchwork

DISC = (HypothesisTerm("defocus", Defocus, {"radius_px": 4.0}, {"radius_px": 0.1}),)
GAUSSIAN = (HypothesisTerm("lens-blur", LensBlur, {"sigma_px": 2.0}, {"sigma_px": 0.1}),)
LINE = (HypothesisTerm("motion-blur", MotionBlur, {"length_px": 11.0, "angle_deg": 0.0}, {"length_px": 0.1}),)


def with_disc(image: NDArray[np.float32], radius_px: float = 4.0) -> NDArray[np.float32]:
    """Mean over the pixels of a disc, each split in 9 x 9 (scipy)."""
    fine = (np.arange(15 * 9) - 67) / 9  # centres of the parts of 15 pixels
    inside = np.hypot(fine[:, None], fine[None, :]) <= radius_px
    kernel = inside.reshape(15, 9, 15, 9).sum(axis=(1, 3)).astype(float)
    return np.asarray(
        ndimage.convolve(image.astype(float), kernel / kernel.sum(), mode="nearest"), np.float32
    )


def with_line(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Mean of 11 neighbours along the rows (scipy)."""
    return np.asarray(ndimage.uniform_filter1d(image, 11, axis=1, mode="nearest"), np.float32)


def with_gaussian(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Pillow's Gaussian of radius 2."""
    whole = Image.fromarray(np.clip(np.round(image), 0, 255).astype(np.uint8))
    return np.asarray(whole.filter(ImageFilter.GaussianBlur(2.0)), np.float32)


def elsewhere(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Turned by half a degree, magnified by 1 % and shifted by a pixel and a half (scipy splines)."""
    turn = np.radians(0.5)
    back = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) / 1.01
    centre = np.array([HEIGHT, WIDTH]) / 2
    return np.asarray(
        ndimage.affine_transform(
            image, back, centre - back @ (centre + np.array([1.2, -0.9])), order=3, mode="nearest"
        )
    )


def scene(image: NDArray[np.float32]) -> RealCapture:
    """A scene whose frames show an image, lit by 8 % more than expected."""
    empty = capture("scene", "scene", patchwork() + BLACK_DN)
    noise = np.random.default_rng(4).normal(0, 2.0, (2, HEIGHT, WIDTH))
    frames = np.clip(np.round(1.08 * (image - BLACK_DN) + BLACK_DN + noise), 0, 255)
    return replace(empty, real_dn=np.asarray(frames[..., None], np.float32))


@pytest.fixture(scope="module")
def sharp() -> NDArray[np.float32]:
    return np.asarray(patchwork() + BLACK_DN, np.float32)


def problem_of(image: NDArray[np.float32]) -> Problem:
    return Problem([ImageEvidence(scene(image), seed=0, replicates=4)])


@pytest.mark.parametrize("blurred", [False, True])
def test_a_picture_is_laid_over_another(sharp, blurred):
    onto = elsewhere(with_disc(sharp) if blurred else sharp)
    moved = laid_over(with_disc(sharp) if blurred else sharp, onto)
    before = float(np.std((onto - sharp)[moved.inside]))
    assert np.std((onto - moved.image)[moved.inside]) < 0.2 * before


def test_what_shows_nothing_is_laid_over_nothing(sharp):
    noise = np.random.default_rng(0).normal(90, 2, sharp.shape).astype(np.float32)
    assert laid_over(sharp, noise) is None
    assert laid_over(np.full_like(sharp, 9.0), sharp) is None
    assert laid_over(sharp[:9, :9], sharp[:9, :9]) is None


KINDS = {"disc": (with_disc, DISC), "line": (with_line, LINE), "gaussian": (with_gaussian, GAUSSIAN)}


@pytest.mark.parametrize("true", KINDS)
def test_the_kind_of_a_blur_shows_whatever_the_pose(sharp, true):
    blur, right = KINDS[true]
    problem = problem_of(elsewhere(blur(sharp)))
    others = [hypothesis for kind, (_, hypothesis) in KINDS.items() if kind != true]
    assert share_of_pictures(problem, right, right[0], others, seed=0) > 0.9
    rivals = [right]
    assert not any(
        BY_PICTURES.by(share_of_pictures(problem, wrong, wrong[0], rivals, seed=0)) for wrong in others
    )


def test_a_rival_whose_fit_went_astray_still_counts_at_its_guesses(sharp):
    problem = problem_of(with_disc(sharp))
    astray = (replace(DISC[0], values={"radius_px": 0.4}),)
    assert share_of_pictures(problem, GAUSSIAN, GAUSSIAN[0], [astray], seed=0) == 0.0


def test_a_pose_is_nobodys_effect_but_a_distortion_is_one(sharp):
    magnified = HypothesisTerm("focal-length-error", FocalLengthError, {"scale": 1.02}, {"scale": 0.01})
    problem = problem_of(elsewhere(sharp))
    assert share_of_pictures(problem, (magnified,), magnified, [], seed=0) < 0.5
    rows, columns = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    x, y = (columns - (WIDTH - 1) / 2) / 333.0, (rows - (HEIGHT - 1) / 2) / 333.0
    k1 = -0.8
    # where a point of the picture comes from: one step of the inverse of x (1 + k1 r^2) and a correction
    u, v = x, y
    for _ in range(8):
        r2 = u**2 + v**2
        u, v = x / (1 + k1 * r2), y / (1 + k1 * r2)
    at = [v * 333.0 + (HEIGHT - 1) / 2, u * 333.0 + (WIDTH - 1) / 2]
    bent = np.asarray(ndimage.map_coordinates(sharp, at, order=3, mode="nearest"), np.float32)
    lens = HypothesisTerm("lens-distortion", LensDistortion, {"k1": k1}, {"k1": 0.01})
    assert share_of_pictures(problem_of(bent), (lens,), lens, [DISC, LINE], seed=0) > 0.6


def test_of_a_large_picture_the_middle_is_compared(sharp):
    wide = replace(
        scene(sharp), valid=np.ones((800, 900), bool), expected_dn=np.resize(sharp, (1, 800, 900, 1)),
        real_dn=np.resize(sharp, (1, 800, 900, 1)),
    )  # fmt: skip
    squares = tile_squares(wide, [[]])
    assert squares.shape == (1, 48)
    assert squares.sum() < 1e-3 * np.var(sharp) * wide.valid.size


def test_defocus_is_named_although_depth_and_glints_leave_a_rest(sharp):
    far, near = with_disc(sharp, 3.0), with_disc(sharp, 4.0)
    real = np.where(np.arange(WIDTH) < WIDTH // 2, far, near)
    real[20:26, 30:36] += 40
    real[80:85, 120:126] += 40
    effects = {"defocus": Defocus, "motion-blur": MotionBlur, "focal-length-error": FocalLengthError}
    found = diagnose(CaptureFolder(None, (scene(elsewhere(real)),)), effects, workers=1)
    assert found.causes[0].effect == "defocus"
    assert found.causes[0].present > 0.5
    assert found.unknown.score > 0.5
