"""Device and random numbers of torch."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager

import numpy as np
import torch

from tacos_framework import Fault, UserError
from tacos_plugins.chosen_device import chosen_device

log = logging.getLogger(__name__)

DEVICE_PATTERN = r"auto|cpu|cuda(:\d+)?"
"""Values of a setting ``device``."""

DEVICE_HELP = "Device: auto (a GPU where there is one), cpu, cuda, or cuda:N."
"""Help of a setting ``device``."""


def pick_device(name: str, *, where: str) -> torch.device:
    """The device a task computes on.

    `name`: ``auto`` is what `chosen_device` says, else the first GPU where CUDA works, else the CPU; or
    ``cpu``, ``cuda``, ``cuda:1``. `where`: what asks for it, for messages: ``task.psmnet``.

    Raises `UserError` when CUDA is asked for and not there, or there are fewer GPUs.
    """
    gpus = torch.cuda.device_count() if torch.cuda.is_available() else 0
    if name == "auto":
        chosen = chosen_device()
        name = f"cuda:{chosen}" if isinstance(chosen, int) else chosen or ("cuda" if gpus else "cpu")
    device = torch.device(name)
    if device.type == "cuda" and (device.index or 0) >= gpus:
        found = f"torch {torch.__version__} finds {gpus or 'no'} CUDA GPU{'s' * (gpus > 1)} here"
        expected = ", ".join(["auto", "cpu", *(f"cuda:{i}" for i in range(gpus))])
        raise UserError(
            Fault(
                where, f"device is {name}, but {found}", expected, "Set device: auto, or see `tacos doctor`."
            )
        )
    on_gpu = device.type == "cuda"
    what = torch.cuda.get_device_name(device) if on_gpu else f"{torch.get_num_threads()} threads"
    log.info("%s computes on %s (%s)", where, device, what)
    return device


@contextmanager
def drawing_from(rng: np.random.Generator, device: torch.device | None = None) -> Iterator[None]:
    """Let torch's own random numbers come from `rng` inside, and leave torch's generators as they were.

    For code that cannot be handed a generator: modules that initialise themselves, samplers, dropout.

    `rng`: gives the seed; the same state gives the same numbers. `device`: the GPU whose generator is seeded
    too; None for the CPU alone.
    """
    gpus = [device] if device is not None and device.type == "cuda" else []
    with torch.random.fork_rng(devices=gpus):
        torch.manual_seed(int(rng.integers(2**63)))
        yield


def mixed_precision(device: torch.device) -> AbstractContextManager[object]:
    """Half precision where a GPU has bfloat16, whose range needs no scaling of losses."""
    enabled = device.type == "cuda" and torch.cuda.is_bf16_supported()
    return torch.autocast(device.type, dtype=torch.bfloat16, enabled=enabled)
