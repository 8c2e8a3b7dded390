"""The detectors: torchvision's Faster R-CNN on three backbones."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from typing import Any, Literal

import torch
from torch import nn
from torchvision.models.detection import (
    FasterRCNN,
    fasterrcnn_mobilenet_v3_large_fpn,
    fasterrcnn_resnet50_fpn,
)
from torchvision.models.detection.anchor_utils import AnchorGenerator
from torchvision.models.detection.backbone_utils import BackboneWithFPN
from torchvision.models.detection.faster_rcnn import FastRCNNPredictor, TwoMLPHead
from torchvision.models.resnet import BasicBlock
from torchvision.ops import MultiScaleRoIAlign

from tacos_plugins.tasks.faster_rcnn.images import CameraPixels

Backbone = Literal["resnet50-fpn", "mobilenet-v3-fpn", "narrow-fpn"]

ASPECT_RATIOS = (0.5, 1.0, 2.0)
"""Height over width of the anchors."""

SMALLEST_ANCHOR_PX = {"resnet50-fpn": 32.0, "mobilenet-v3-fpn": 32.0, "narrow-fpn": 12.0}
"""Edge of the smallest anchors; the next are twice as large each [px]."""

STRIDES_PX = 128
"""Edge of an image that all strides divide [px]."""

NARROW_STEM = 24
NARROW_WIDTHS = (32, 48, 64, 96)
"""Channels of the narrow backbone at strides of 4, 8, 16 and 32 pixels."""
NARROW_PYRAMID = 64
NARROW_POOLED_PX = 5
NARROW_HEAD = 128


def faster_rcnn(
    backbone: Backbone,
    classes: int,
    *,
    proposals: int,
    rois: int,
    detections: int,
    score_threshold: float,
    smallest_anchor_px: float | None,
    pixels: CameraPixels,
) -> FasterRCNN:
    """A detector with weights as its parts initialise themselves, from torch's generator.

    - `backbone`: ``resnet50-fpn`` and ``mobilenet-v3-fpn`` are torchvision's builders; ``narrow-fpn`` is the
      same detector on a small residual backbone, 0.7 million parameters in all, for CPUs.
    - `classes`: classes, the background not counted.
    - `proposals`: regions the first stage hands to the second.
    - `rois`: regions per image the second stage is trained on; the first is trained on as many anchors.
    - `detections`: detections per image at most.
    - `score_threshold`: confidence below which nothing is detected.
    - `smallest_anchor_px`: edge of the smallest anchors in the network's image; None leaves it to the
      backbone [px].
    - `pixels`: how images come to the network's size.
    """
    settings: dict[str, Any] = {
        "rpn_pre_nms_top_n_train": 2 * proposals,
        "rpn_pre_nms_top_n_test": 2 * proposals,
        "rpn_post_nms_top_n_train": proposals,
        "rpn_post_nms_top_n_test": proposals,
        "rpn_batch_size_per_image": rois,
        "box_batch_size_per_image": rois,
        "box_detections_per_img": detections,
        "box_score_thresh": score_threshold,
    }
    smallest = SMALLEST_ANCHOR_PX[backbone] if smallest_anchor_px is None else smallest_anchor_px
    if backbone == "narrow-fpn":
        model = _narrow(classes, smallest, settings)
    else:
        build, levels, sizes_per_level = {
            "resnet50-fpn": (fasterrcnn_resnet50_fpn, 5, 1),
            "mobilenet-v3-fpn": (fasterrcnn_mobilenet_v3_large_fpn, 3, 5),
        }[backbone]
        model = build(weights=None, weights_backbone=None, num_classes=classes + 1, **settings)
        model.rpn.anchor_generator = _anchors(smallest, levels, sizes_per_level)
    model.transform = pixels
    _learn_strides(model)
    return model


def still_norms(model: nn.Module) -> None:
    """Take the batch normalisation of a model out of training, statistics, gains and offsets."""
    for part in model.modules():
        if isinstance(part, nn.BatchNorm2d):
            part.eval()
            part.requires_grad_(False)


def _learn_strides(model: FasterRCNN) -> None:
    """Let the pooling of regions take its strides from an image whose size they all divide.

    It takes them from the first image it meets, before padding, and keeps them: after one of 34 pixels
    that was padded to 64, it would look for all regions in the wrong place ever after.
    """
    size = (STRIDES_PX, STRIDES_PX)
    model.eval()
    with torch.no_grad():
        features = model.backbone(torch.zeros(1, 3, *size))
        model.roi_heads.box_roi_pool(features, [torch.tensor([[0.0, 0.0, *size]])], [size])
    model.train()


def _anchors(smallest_px: float, levels: int, sizes_per_level: int) -> AnchorGenerator:
    """Anchors of doubling size: one size a level, or where there are several, all of them at each level."""
    sizes = [tuple(smallest_px * 2**i for i in range(sizes_per_level))] * levels
    if sizes_per_level == 1:
        sizes = [(smallest_px * 2**i,) for i in range(levels)]
    return AnchorGenerator(tuple(sizes), (ASPECT_RATIOS,) * levels)


def _narrow(classes: int, smallest_px: float, settings: dict[str, Any]) -> FasterRCNN:
    levels = len(NARROW_WIDTHS)
    returned = {f"layer{i}": str(i - 1) for i in range(1, levels + 1)}
    body = _narrow_backbone(NARROW_STEM, NARROW_WIDTHS)
    backbone = BackboneWithFPN(body, returned, list(NARROW_WIDTHS), NARROW_PYRAMID)
    backbone.fpn.extra_blocks = None  # a level of stride 64 would be a pixel or two in images this small
    return FasterRCNN(
        backbone,
        rpn_anchor_generator=_anchors(smallest_px, levels, 1),
        box_roi_pool=MultiScaleRoIAlign(list(returned.values()), NARROW_POOLED_PX, sampling_ratio=2),
        box_head=TwoMLPHead(NARROW_PYRAMID * NARROW_POOLED_PX**2, NARROW_HEAD),
        box_predictor=FastRCNNPredictor(NARROW_HEAD, classes + 1),
        **settings,
    )


def _narrow_backbone(stem: int, widths: Sequence[int]) -> nn.Sequential:
    """One residual block at each stride; small images keep twice the detail of ResNet's stem."""
    parts: OrderedDict[str, nn.Module] = OrderedDict()
    parts["stem"] = nn.Sequential(
        nn.Conv2d(3, stem, 3, stride=2, padding=1, bias=False), nn.BatchNorm2d(stem), nn.ReLU(inplace=True)
    )
    before = stem
    for i, width in enumerate(widths, start=1):
        shortcut = nn.Sequential(nn.Conv2d(before, width, 1, stride=2, bias=False), nn.BatchNorm2d(width))
        parts[f"layer{i}"] = BasicBlock(before, width, stride=2, downsample=shortcut)
        before = width
    backbone = nn.Sequential(parts)
    for part in backbone.modules():
        if isinstance(part, nn.Conv2d):
            nn.init.kaiming_normal_(part.weight, mode="fan_out", nonlinearity="relu")
    return backbone
