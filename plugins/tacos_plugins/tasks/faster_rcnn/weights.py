"""Weights a detector starts with: none, a file, those that are shipped, or torchvision's own."""

from __future__ import annotations

from pathlib import Path
from urllib.error import URLError

import torch
from torch import Tensor, nn
from torchvision.models.detection import (
    FasterRCNN,
    FasterRCNN_MobileNet_V3_Large_FPN_Weights,
    FasterRCNN_ResNet50_FPN_Weights,
)

from tacos_framework import Fault, UserError
from tacos_plugins.tasks.faster_rcnn.networks import Backbone
from tacos_plugins.tasks.learning.checkpoints import load_checkpoint, named_weights, read_checkpoint

COCO = "coco"
"""Value of a setting ``weights`` for torchvision's own."""
WHERE = "task.faster-rcnn: weights"

PREDICTOR = "roi_heads.box_predictor."
"""Begins the names of the last layer, which knows the classes."""

NORM_EPSILON_OF_COCO = {"resnet50-fpn": 0.0}
"""Epsilon of torchvision's published weights, where it is not the usual."""


def weights_file(name: str) -> Path | None:
    """The file a setting ``weights`` names, shipped or by its path; None where it names none.

    Raises `UserError` when there is no such file.
    """
    return None if name == COCO else named_weights(name, where=WHERE, others=(COCO,))


def load_weights(model: FasterRCNN, name: str, backbone: Backbone) -> None:
    """Load what a setting ``weights`` names into a model.

    Raises `UserError` when the file is no checkpoint of this detector, or torchvision's weights cannot be
    had.
    """
    file = weights_file(name)
    if file is not None:
        classes = model.roi_heads.box_predictor.cls_score.out_features - 1
        made_for = f"the detector {backbone} of {classes} classes"
        load_checkpoint(read_checkpoint(file, where=WHERE), model, where=WHERE, made_for=made_for)
    elif name == COCO:
        model.load_state_dict(_but_for_the_classes(_coco_weights(backbone), model, backbone))


def _coco_weights(backbone: Backbone) -> dict[str, Tensor]:
    """torchvision's weights, from its cache or the network."""
    published = {
        "resnet50-fpn": FasterRCNN_ResNet50_FPN_Weights.COCO_V1,
        "mobilenet-v3-fpn": FasterRCNN_MobileNet_V3_Large_FPN_Weights.COCO_V1,
    }
    if backbone not in published:
        raise UserError(
            Fault(WHERE, f"torchvision publishes none for {backbone}", "", f"Use {' or '.join(published)}.")
        )
    weights = published[backbone]
    try:
        return dict(weights.get_state_dict(progress=False, check_hash=True))
    except (URLError, OSError, RuntimeError) as error:
        cache = Path(torch.hub.get_dir()) / "checkpoints" / weights.url.rpartition("/")[2]
        reason = getattr(error, "reason", error)
        raise UserError(
            Fault(
                WHERE,
                f"torchvision's weights could not be downloaded from {weights.url}: {reason}",
                "a network, or the file in torch's cache",
                f"Put the file at {cache}, or name other weights; the recipe pretrain_detector makes some.",
            )
        ) from error


def _but_for_the_classes(
    given: dict[str, Tensor], model: FasterRCNN, backbone: Backbone
) -> dict[str, Tensor]:
    """Weights of other classes, with the model's own last layer and its batch normalisation's epsilon."""
    own = model.state_dict()
    taken = {name: given.get(name, own[name]) for name in own}
    taken |= {name: value for name, value in own.items() if name.startswith(PREDICTOR)}
    if (epsilon := NORM_EPSILON_OF_COCO.get(backbone)) is not None:
        for name, part in model.named_modules():
            if isinstance(part, nn.BatchNorm2d) and f"{name}.running_var" in given:
                taken[f"{name}.running_var"] = given[f"{name}.running_var"] + (epsilon - part.eps)
    return taken
