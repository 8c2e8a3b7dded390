"""What reaches the network: light in 0..1, in the camera's own pixels, normalised once."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("torchvision", reason="the extra perception is not installed")

import torch

from tacos_plugins.tasks.faster_rcnn.images import CameraPixels
from tacos_plugins.tasks.faster_rcnn.networks import faster_rcnn
from tacos_plugins.tasks.learning.images import DEVIATION, MEAN, network_image

CPU = torch.device("cpu")


def seen(image, black=0.0, white=255.0):
    return network_image(np.asarray(image), CPU, black_level_dn=black, white_level_dn=white)


def test_black_is_zero_and_white_is_one_whatever_the_bit_depth():
    twelve = np.array([[[64, 64, 64], [4095, 4095, 4095], [10, 10, 10]]], np.uint16)
    assert seen(twelve, 64, 4095)[0].tolist() == [[0.0, 1.0, 0.0]]
    assert seen(np.array([[[0, 0, 0], [255, 255, 255]]], np.uint8))[0].tolist() == [[0.0, 1.0]]


def test_a_mono_image_has_three_equal_channels():
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4, 1)
    image = seen(grey)
    assert image.shape == (3, 3, 4)
    assert torch.equal(image[0], image[2])


def test_colours_keep_their_order():
    assert seen(np.array([[[255, 0, 51]]], np.uint8))[:, 0, 0].tolist() == pytest.approx([1, 0, 0.2])


def test_the_network_normalises_once():
    """Its input is 0..1; mean and deviation are taken off inside, and nowhere else."""
    pixels = CameraPixels(1.0, None, None)
    white = torch.ones(3, 32, 32)
    images, _ = pixels([white])
    assert images.tensors[0, :, 0, 0].tolist() == pytest.approx(
        [(1 - mean) / deviation for mean, deviation in zip(MEAN, DEVIATION, strict=True)]
    )


@pytest.mark.parametrize("training", [True, False])
def test_by_default_a_camera_s_pixels_stay_what_they_are(training):
    """torchvision's own transform would make both 800 pixels high, and resolution would not tell."""
    pixels = CameraPixels(1.0, None, None).train(training)
    images, _ = pixels([torch.rand(3, 48, 64), torch.rand(3, 96, 128)])
    assert images.image_sizes == [(48, 64), (96, 128)]


@pytest.mark.parametrize(
    ("settings", "size"),
    [
        ((2.0, None, None), (96, 128)),
        ((1.0, 96, None), (96, 128)),
        ((1.0, 40, None), (48, 64)),
        ((1.0, None, 32), (24, 32)),
        ((1.0, None, 100), (48, 64)),
        ((1.0, 96, 100), (75, 100)),
    ],
)
def test_sizes_that_are_asked_for_are_kept_and_boxes_follow(settings, size):
    pixels = CameraPixels(*settings)
    box = torch.tensor([[0.0, 12.0, 64.0, 48.0]])
    images, targets = pixels([torch.rand(3, 48, 64)], [{"boxes": box, "labels": torch.tensor([1])}])
    assert images.image_sizes == [size]
    height, width = size
    assert targets[0]["boxes"][0].tolist() == pytest.approx([0, height / 4, width, height])
    assert box.tolist() == [[0.0, 12.0, 64.0, 48.0]]
    found = pixels.eval().postprocess([{"boxes": targets[0]["boxes"]}], [size], [(48, 64)])
    assert found[0]["boxes"][0].tolist() == pytest.approx(box[0].tolist())


def test_an_image_of_a_few_pixels_can_be_learnt_from():
    """Batch normalisation refuses to take the statistics of a single value."""
    pixels = CameraPixels(1.0, None, None)
    images, _ = pixels([torch.rand(3, 5, 7)])
    assert images.tensors.shape == (1, 3, 64, 64)
    assert images.image_sizes == [(5, 7)]
    assert not images.tensors[0, :, 5:].any()


@pytest.mark.parametrize("backbone", ["narrow-fpn", "mobilenet-v3-fpn", "resnet50-fpn"])
def test_a_tiny_image_does_not_change_what_is_found_in_the_next(backbone):
    """torchvision's pooling keeps the strides that it takes from the first image, before it is padded."""
    torch.manual_seed(0)
    settings = {"proposals": 20, "rois": 8, "detections": 20, "score_threshold": 0.0}
    model = faster_rcnn(
        backbone, 2, smallest_anchor_px=None, pixels=CameraPixels(1.0, None, None), **settings
    ).eval()
    assert model.roi_heads.box_roi_pool.scales[0] in (1 / 4, 1 / 32)
    image = torch.rand(3, 96, 128)
    with torch.no_grad():
        (before,) = model([image])
        model([torch.rand(3, 34, 46)])
        (after,) = model([image])
        fresh = faster_rcnn(
            backbone, 2, smallest_anchor_px=None, pixels=CameraPixels(1.0, None, None), **settings
        ).eval()
        fresh.load_state_dict(model.state_dict())
        fresh([torch.rand(3, 34, 46)])
        (first_tiny,) = fresh([image])
    assert torch.equal(before["boxes"], after["boxes"])
    assert torch.equal(before["scores"], first_tiny["scores"])
