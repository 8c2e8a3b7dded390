"""What may go wrong in training: losses that are no number, and too little memory."""

from __future__ import annotations

import logging

import pytest

from tacos_framework.errors import CandidateFailed, UserError

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.learning.guard import (  # noqa: E402
    TrainingDiverged,
    finite,
    halving_batch_once,
    naming_lack_of_memory,
)


def test_numbers_pass():
    assert finite(torch.tensor(2.5, requires_grad=True), step=1, where="task.test") == 2.5


@pytest.mark.parametrize("loss", [float("nan"), float("inf"), -float("inf")])
def test_what_is_no_number_fails_the_candidate(loss):
    with pytest.raises(TrainingDiverged, match=f"task.test diverged: its loss is {loss} at step 7"):
        finite(torch.tensor(loss), step=7, where="task.test")
    assert issubclass(TrainingDiverged, CandidateFailed)


def fitting_within(limit: int, error: Exception):
    tried: list[int] = []

    def fit(batch_size: int) -> list[int]:
        tried.append(batch_size)
        if batch_size > limit:
            raise error
        return tried

    return fit, tried


OUT_OF_MEMORY = [
    torch.OutOfMemoryError("CUDA out of memory."),
    RuntimeError("[enforce fail] DefaultCPUAllocator: can't allocate memory"),
]


@pytest.mark.parametrize("error", OUT_OF_MEMORY)
def test_the_batch_is_halved_once_and_said(error, caplog):
    fit, tried = fitting_within(2, error)
    with caplog.at_level(logging.WARNING):
        assert halving_batch_once(fit, 4, where="task.test") == [4, 2]
    assert caplog.messages == ["task.test: out of memory; training anew with batches of 2"]
    assert tried == [4, 2]


@pytest.mark.parametrize(("batch", "tries"), [(8, [8, 4]), (1, [1])])
def test_then_it_is_the_users_to_decide(batch, tries):
    fit, tried = fitting_within(0, OUT_OF_MEMORY[0])
    with pytest.raises(UserError, match=f"runs out of memory with batches of {tries[-1]}"):
        halving_batch_once(fit, batch, where="task.test")
    assert tried == tries


def test_other_errors_pass_unchanged():
    fit, tried = fitting_within(0, RuntimeError("shapes do not match"))
    with pytest.raises(RuntimeError, match="shapes do not match"):
        halving_batch_once(fit, 4, where="task.test")
    with pytest.raises(RuntimeError, match="shapes"), naming_lack_of_memory("it is full", where="task.test"):
        fit(2)
    assert tried == [4, 2]


def test_real_lack_of_memory_is_recognised():
    with pytest.raises(UserError, match="it is full"), naming_lack_of_memory("it is full", where="task.test"):
        torch.empty(2**55)
