"""What PSMNet is trained on, and the loss it is trained with."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tasks.stereo_frames import FAR_M, NEAR_M, stereo_frames, stereo_rig

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.psmnet.training import disparity_loss, network_pairs  # noqa: E402
from tacos_plugins.tasks.stereo.examples import StereoExample, stereo_examples  # noqa: E402
from tacos_plugins.tasks.stereo.pair import StereoPair, stereo_pair  # noqa: E402

CPU = torch.device("cpu")
PAIR = StereoPair(0, 1, width_px=8, height_px=4, focal_length_px=100.0, baseline_m=0.5)


def example(left, right=None, *, depth_m=None, black=0.0, white=255.0):
    right = left if right is None else right
    depth = np.full(left.shape[:2], 5.0, np.float32) if depth_m is None else np.float32(depth_m)
    return StereoExample(left, right, black, white, depth, PAIR)


# loss -----------------------------------------------------------------------------------------------------


def test_the_loss_by_hand():
    truth = torch.tensor([[[4.0, 10.0], [0.0, 16.0]]])  # the last two do not count
    off = torch.tensor([[[0.5, -3.0], [7.0, 7.0]]])
    smooth = (0.5 * 0.5**2 + (3.0 - 0.5)) / 2  # smooth L1: quadratic below 1, linear above
    loss = disparity_loss([truth + off] * 3, truth, max_disparity=16)
    assert loss.item() == pytest.approx((0.5 + 0.7 + 1.0) * smooth)


def test_hourglasses_weigh_more_the_later_they_stand():
    truth = torch.full((1, 1, 1), 5.0)
    right, wrong = truth, truth + 1.5  # a smooth L1 of 1
    losses = [
        disparity_loss([wrong if i == j else right for j in range(3)], truth, max_disparity=16).item()
        for i in range(3)
    ]
    assert losses == pytest.approx([0.5, 0.7, 1.0])


def test_without_a_pixel_that_counts_there_is_no_loss():
    estimates = [torch.ones(1, 2, 2, requires_grad=True)] * 3
    loss = disparity_loss(estimates, torch.tensor([[[0.0, 16.0], [99.0, -1.0]]]), max_disparity=16)
    assert loss.item() == 0.0


# truth ----------------------------------------------------------------------------------------------------


def test_disparity_is_that_of_the_candidates_own_camera():
    for baseline_m, focal_px in ((0.1, 90.0), (0.8, 150.0)):
        rig = stereo_rig(baseline_m=baseline_m, focal_length_px=focal_px)
        pair = stereo_pair(
            rig.cameras, left=None, right=None, smallest_px=1, largest_px=192, max_depth_m=1000.0
        )
        (first, *_) = stereo_examples(stereo_frames(rig, 1, sky_rows=3), pair)
        truth = first.disparity_px(max_depth_m=1000.0, sky=True)
        assert truth[32, 64] == pytest.approx(focal_px * baseline_m / NEAR_M)
        assert truth[-1, 0] == pytest.approx(focal_px * baseline_m / FAR_M)
        assert truth[0, 0] == pytest.approx(focal_px * baseline_m / 1000.0)


def test_the_images_show_the_disparity_the_depth_says():
    """The right image, moved by the truth, is the left one."""
    rig = stereo_rig(baseline_m=0.5)
    frames = stereo_frames(rig, 1, noise_dn=0.0)
    left, right = (image[0, ..., 0].astype(float) for image in frames.images)
    moved_px = 110.0 * 0.5 / FAR_M
    row, columns = 3, np.arange(10, 120)
    there = np.interp(columns - moved_px, np.arange(128), right[row])
    assert np.abs(there - left[row, columns]).mean() < 0.1 * left[row].std()


def test_sky_is_trained_on_only_where_wanted():
    pixels = example(np.zeros((1, 3, 3), np.uint8), depth_m=[[10.0, 2000.0, np.inf]])
    with_sky = pixels.disparity_px(max_depth_m=1000.0, sky=True)
    assert with_sky[0].tolist() == pytest.approx([5.0, 0.05, 0.05])
    assert pixels.disparity_px(max_depth_m=1000.0, sky=False)[0].tolist() == pytest.approx([5.0, 0, 0])


def test_windows_are_the_same_in_both_images_and_in_the_depth():
    rng = np.random.default_rng(1)
    left = rng.integers(0, 255, (40, 60, 3)).astype(np.uint8)
    whole = example(left, left + 1, depth_m=left[..., 0] + 1.0)
    window = whole.cropped(16, 8, rng)
    assert window.left_dn.shape == (8, 16, 3)
    np.testing.assert_array_equal(window.right_dn, window.left_dn + 1)
    np.testing.assert_array_equal(window.depth_m, window.left_dn[..., 0] + 1.0)
    assert whole.cropped(100, 100, rng).left_dn.shape == left.shape


def test_windows_reach_every_edge():
    rng = np.random.default_rng(2)
    columns = np.tile(np.arange(6, dtype=np.uint8)[None, :, None], (4, 1, 3))
    starts = {int(example(columns).cropped(4, 4, rng).left_dn[0, 0, 0]) for _ in range(50)}
    assert starts == {0, 1, 2}


# images ---------------------------------------------------------------------------------------------------


def test_images_are_normalised_once():
    rng = np.random.default_rng(3)
    image = rng.integers(0, 4096, (4, 8, 3)).astype(np.uint16)
    left, right = network_pairs([example(image, black=64, white=4095)], CPU)
    colour = np.clip((image - 64.0) / (4095 - 64), 0, 1)
    expected = (colour - [0.485, 0.456, 0.406]) / [0.229, 0.224, 0.225]
    np.testing.assert_allclose(left[0].permute(1, 2, 0).numpy(), expected, atol=1e-5)
    assert torch.equal(left, right)


def test_mono_images_become_grey():
    image = np.full((4, 8, 1), 128, np.uint8)
    mono, _ = network_pairs([example(image)], CPU)
    colour, _ = network_pairs([example(np.repeat(image, 3, 2))], CPU)
    assert torch.equal(mono, colour)
