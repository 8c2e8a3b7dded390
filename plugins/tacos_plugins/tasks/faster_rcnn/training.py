"""Training a detector on examples."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
import torch
from torch import Tensor
from torchvision.models.detection import FasterRCNN

from tacos_framework import Settings, setting
from tacos_plugins.tasks.faster_rcnn.examples import Example, in_parts, mixed_batches
from tacos_plugins.tasks.faster_rcnn.networks import still_norms
from tacos_plugins.tasks.faster_rcnn.schedule import learning_rate
from tacos_plugins.tasks.learning.device import mixed_precision
from tacos_plugins.tasks.learning.guard import finite, finite_weights
from tacos_plugins.tasks.learning.images import network_image

WHERE = "task.faster-rcnn"


class DetectorTraining(Settings):
    """Training of the detector: further keys of a recipe's ``train:``."""

    learning_rate: float = setting(1e-4, help="Adam's learning rate at the start.", gt=0, also=("lr",))
    batch_size: int = setting(8, help="Frames in a step of Adam.", unit="frames", ge=1)
    frames_at_once: int | None = setting(
        None,
        help="Frames of a batch computed together, gradients summed up; by default all. Spares memory.",
        unit="frames",
        ge=1,
    )
    decay: float = setting(0.5, help="Factor on the learning rate at each decay.", gt=0, le=1)
    decay_every: int = setting(
        5, help="Passes over training frames between decays; with shared weights each candidate is one.", ge=1
    )
    decay_floor: float = setting(
        0.05, help="Share of the first learning rate it never falls below.", ge=0, le=1
    )
    warm_up_steps: int = setting(
        0, help="Steps of Adam over which the rate rises at first: from nothing, full steps kill units.", ge=0
    )
    gradient_limit: float | None = setting(
        None, help="Norm of the gradient above which it is scaled down; by default any.", gt=0
    )
    shuffled_frames: int = setting(
        32, help="Frames held in memory to draw batches from.", unit="frames", ge=1
    )
    mirror: bool = setting(True, help="Mirror every other frame, at random.")


def train(
    model: FasterRCNN,
    adam: torch.optim.Adam,
    examples: Callable[[], Iterable[Example]],
    *,
    epochs: int,
    passes: int,
    training: DetectorTraining,
    batch_size: int,
    norms: bool,
    rng: np.random.Generator,
    on_step: Callable[[Mapping[str, float]], None] | None,
) -> int:
    """Train a model in place.

    `examples`: gives the training frames anew for each pass.

    Returns: passes it was trained for now.

    Raises `TrainingDiverged` when the loss is no number, or the last step has made weights that are none.
    """
    model.train()
    if not norms:
        still_norms(model)
    step = 0
    for _ in range(epochs):
        rate = learning_rate(
            passes,
            start=training.learning_rate,
            decay=training.decay,
            decay_every=training.decay_every,
            floor=training.decay_floor,
        )
        for batch in mixed_batches(examples(), batch_size, training.shuffled_frames, rng):
            if training.mirror:
                batch = [each.mirrored() if rng.random() < 0.5 else each for each in batch]
            warm = min(1.0, (_steps_of(adam) + 1) / max(1, training.warm_up_steps))
            for group in adam.param_groups:
                group["lr"] = rate * warm
            at_once = training.frames_at_once or batch_size
            losses = _step(model, adam, batch, at_once, training.gradient_limit, step)
            step += 1
            if on_step is not None:
                on_step(losses)
        passes += 1
    if step:
        finite_weights(model, where=WHERE)
    return passes


def _step(
    model: FasterRCNN,
    adam: torch.optim.Adam,
    batch: Sequence[Example],
    at_once: int,
    gradient_limit: float | None,
    step: int,
) -> dict[str, float]:
    """One step of Adam; the mean losses of the batch."""
    device = next(model.parameters()).device
    means: dict[str, float] = {}
    adam.zero_grad(set_to_none=True)
    for part in in_parts(batch, at_once):
        share = len(part) / len(batch)
        with mixed_precision(device):
            losses: dict[str, Tensor] = model(inputs(part, device), [_target(each, device) for each in part])
        loss = torch.stack([each.float() for each in losses.values()]).sum()
        values = {"loss": finite(loss, step=step, where=WHERE)}
        values |= {name: float(each.detach()) for name, each in losses.items()}
        (loss * share).backward()
        means = {name: means.get(name, 0.0) + share * value for name, value in values.items()}
    if gradient_limit is not None:
        torch.nn.utils.clip_grad_norm_(model.parameters(), gradient_limit)
    adam.step()
    return means


def _steps_of(adam: torch.optim.Adam) -> int:
    """Steps Adam has made, those before this training included."""
    return max((int(kept["step"]) for kept in adam.state.values()), default=0)


def inputs(batch: Sequence[Example], device: torch.device) -> list[Tensor]:
    return [
        network_image(
            example.image_dn,
            device,
            black_level_dn=example.black_level_dn,
            white_level_dn=example.white_level_dn,
        )
        for example in batch
    ]


def _target(example: Example, device: torch.device) -> dict[str, Tensor]:
    counted = example.labels.counted()
    return {
        "boxes": torch.from_numpy(np.ascontiguousarray(counted.boxes_px)).to(device, non_blocking=True),
        "labels": torch.from_numpy(np.ascontiguousarray(counted.classes)).to(device, non_blocking=True),
    }
