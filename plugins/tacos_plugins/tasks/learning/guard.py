"""Failures of training and their handling."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import torch
from torch import Tensor, nn

from tacos_framework import CandidateFailed, Fault, UserError

log = logging.getLogger(__name__)

Fitted = TypeVar("Fitted")


class TrainingDiverged(CandidateFailed):
    """The loss is no longer a number.

    The optimizer observes that the candidate failed; the study goes on from the weights before it, which
    training leaves as they were.
    """


def finite(loss: Tensor, *, step: int, where: str) -> float:
    """The value of a loss, which must be a number.

    Raises `TrainingDiverged` when it is NaN or infinite.
    """
    value = float(loss.detach())
    if not math.isfinite(value):
        raise TrainingDiverged(f"training of {where} diverged: its loss is {value} at step {step}")
    return value


def finite_weights(module: nn.Module, *, where: str) -> None:
    """Refuse weights that a last step has made other than numbers.

    Raises `TrainingDiverged` when there are NaN or infinite ones; names the first entry.
    """
    for name, tensor in module.state_dict().items():
        if not bool(torch.isfinite(tensor).all()):
            raise TrainingDiverged(f"training of {where} diverged: {name} is no longer finite")


def halving_batch_once(fit: Callable[[int], Fitted], batch_size: int, *, where: str) -> Fitted:
    """The result of training with this batch size, or with half of it where memory runs out.

    `fit`: trains from the start with a batch size; called a second time where the first ran out of memory.

    Raises `UserError` when memory runs out with half a batch too, or a batch is a single sample.
    """
    if batch_size > 1:
        try:
            return fit(batch_size)
        except RuntimeError as error:
            if not is_out_of_memory(error):
                raise
        batch_size //= 2  # beyond the except clause, whose traceback holds on to the tensors
        torch.cuda.empty_cache()
        log.warning("%s: out of memory; training anew with batches of %d", where, batch_size)
    with naming_lack_of_memory(f"{where} runs out of memory with batches of {batch_size}", where=where):
        return fit(batch_size)


@contextmanager
def naming_lack_of_memory(what: str, *, where: str) -> Iterator[None]:
    """Turn torch's complaint about memory into one the user can act on."""
    try:
        yield
    except RuntimeError as error:
        if not is_out_of_memory(error):
            raise
        remedy = "Set smaller images (binning), smaller settings of the network, or device: cpu."
        raise UserError(Fault(where, what, "memory for one step", remedy)) from error


def is_out_of_memory(error: RuntimeError) -> bool:
    """True if torch found no memory, on a GPU or on the CPU, where it says so in words alone."""
    return isinstance(error, torch.OutOfMemoryError) or "DefaultCPUAllocator" in str(error)
