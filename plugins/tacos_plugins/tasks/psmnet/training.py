"""Training PSMNet on pairs."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from tacos_framework import Settings, setting
from tacos_plugins.tasks.learning.batching import in_batches, mixed
from tacos_plugins.tasks.learning.device import mixed_precision
from tacos_plugins.tasks.learning.guard import finite, finite_weights
from tacos_plugins.tasks.learning.images import network_image, normalised, on_device
from tacos_plugins.tasks.psmnet.network import PSMNet
from tacos_plugins.tasks.stereo.examples import StereoExample

log = logging.getLogger(__name__)

WHERE = "task.psmnet"

SMALLEST_PX = 32
"""Least width and height of an image: below, batch normalisation may be left with a single value [px]."""

HEAD_WEIGHTS = (0.5, 0.7, 1.0)
"""Weights of the losses after the three hourglasses (Chang and Chen 2018, Sec. 3.5)."""


class PsmnetTraining(Settings):
    """Training of PSMNet: further keys of a recipe's ``train:``."""

    learning_rate: float = setting(1e-3, help="Adam's learning rate.", gt=0, le=1, also=("lr",))
    batch_size: int = setting(4, help="Pairs in a step of Adam.", unit="pairs", ge=1)
    crop_width_px: int = setting(
        512, help="Width of the random windows trained on; at most the image's.", unit="px", ge=SMALLEST_PX
    )
    crop_height_px: int = setting(
        256, help="Height of the random windows trained on; at most the image's.", unit="px", ge=SMALLEST_PX
    )
    shuffled_frames: int = setting(32, help="Pairs held in memory to draw batches from.", unit="pairs", ge=1)
    sky: bool = setting(
        True, help="Train on what lies beyond the largest depth as if it stood there, as the paper does."
    )


def train(
    network: PSMNet,
    adam: torch.optim.Adam,
    examples: Callable[[], Iterable[StereoExample]],
    *,
    epochs: int,
    training: PsmnetTraining,
    batch_size: int,
    max_depth_m: float,
    rng: np.random.Generator,
    on_step: Callable[[Mapping[str, float]], None] | None,
) -> None:
    """Train a network in place.

    Batches without any pixel to learn from are passed over. A GPU works on a batch while the next one is
    rendered: its loss is looked at only then.

    `examples`: gives the training pairs anew for each pass.

    Raises `TrainingDiverged` when the loss or the weights are no longer numbers.
    """
    network.train()
    losses: list[Tensor] = []

    def look_at_the_last() -> None:
        if losses:
            value = finite(losses[-1], step=len(losses), where=WHERE)
            if on_step is not None:
                on_step({"loss": value})

    passed_over = 0
    for _ in range(epochs):
        shuffled = mixed(examples(), training.shuffled_frames, rng)
        for whole in in_batches(shuffled, batch_size):
            batch = _windows(whole, training, rng)
            look_at_the_last()
            truth_px = np.stack([e.disparity_px(max_depth_m=max_depth_m, sky=training.sky) for e in batch])
            if not ((truth_px > 0) & (truth_px < network.max_disparity)).any():
                passed_over += 1
                continue
            losses.append(_step(network, adam, batch, truth_px))
    look_at_the_last()
    if losses:
        finite_weights(network, where=WHERE)
    if passed_over:
        limit = f"between 0 and {network.max_disparity} px"
        log.warning("%s: %d batches have no disparity %s to learn from", WHERE, passed_over, limit)


def disparity_loss(estimates: Sequence[Tensor], truth_px: Tensor, max_disparity: int) -> Tensor:
    """The weighted sum of smooth L1 over the estimates of the three hourglasses.

    `estimates`: (N, H, W) each, the last hourglass last [px]. `truth_px`: (N, H, W); pixels count where it is
    above 0 and below `max_disparity` [px].

    Returns: a scalar; 0 where no pixel counts.

    Source: Chang and Chen 2018, eq. 3 and 4; with the weights of Sec. 3.5.
    """
    counts = (truth_px > 0) & (truth_px < max_disparity)
    pixels = counts.sum().clamp(min=1)
    losses = [
        weight * (functional.smooth_l1_loss(estimate, truth_px, reduction="none") * counts).sum() / pixels
        for weight, estimate in zip(HEAD_WEIGHTS, estimates, strict=True)
    ]
    return torch.stack(losses).sum()


def network_pairs(examples: Sequence[StereoExample], device: torch.device) -> list[Tensor]:
    """The left and the right images of pairs of one size, (N, 3, H, W) each, as the network takes them."""
    return [
        torch.stack(
            [
                normalised(
                    network_image(
                        image_dn,
                        device,
                        black_level_dn=example.black_level_dn,
                        white_level_dn=example.white_level_dn,
                    )
                )
                for example, image_dn in zip(examples, images_dn, strict=True)
            ]
        )
        for images_dn in ([e.left_dn for e in examples], [e.right_dn for e in examples])
    ]


def _windows(
    examples: Sequence[StereoExample], training: PsmnetTraining, rng: np.random.Generator
) -> list[StereoExample]:
    """Windows of one size, that of the smallest image where it is smaller than asked for."""
    heights, widths = zip(*(example.depth_m.shape for example in examples), strict=True)
    width, height = min(training.crop_width_px, *widths), min(training.crop_height_px, *heights)
    return [example.cropped(width, height, rng) for example in examples]


def _step(
    network: PSMNet, adam: torch.optim.Adam, batch: Sequence[StereoExample], truth_px: NDArray[np.float32]
) -> Tensor:
    """One step of Adam; returns the loss before it."""
    device = next(network.parameters()).device
    left, right = network_pairs(batch, device)
    truth = on_device(truth_px, device)
    with mixed_precision(device):
        estimates = network(left, right)
    loss = disparity_loss(estimates, truth, network.max_disparity)
    adam.zero_grad(set_to_none=True)
    loss.backward()
    adam.step()
    return loss.detach()
