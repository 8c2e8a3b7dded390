"""Where torch computes, and with what random numbers."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tacos_framework.errors import UserError

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.learning.device import DEVICE_PATTERN, drawing_from, pick_device  # noqa: E402


def test_the_cpu_is_there_always():
    assert pick_device("cpu", where="task.test") == torch.device("cpu")


@pytest.mark.parametrize(("gpus", "expected"), [(0, "cpu"), (2, "cuda")])
def test_auto_takes_a_gpu_where_there_is_one(monkeypatch, gpus, expected):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: gpus > 0)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: gpus)
    monkeypatch.setattr(torch.cuda, "get_device_name", lambda device: "a GPU")
    assert pick_device("auto", where="task.test") == torch.device(expected)


@pytest.mark.parametrize("name", ["cuda", "cuda:0"])
def test_cuda_asked_for_and_missing(monkeypatch, name):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    with pytest.raises(
        UserError, match=rf"task.test: device is {name}, but torch .* finds no CUDA GPU"
    ) as caught:
        pick_device(name, where="task.test")
    (fault,) = caught.value.faults
    assert fault.expected == "auto, cpu"
    assert "device: auto" in fault.remedy


def test_a_gpu_beyond_those_there(monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 2)
    with pytest.raises(UserError, match=r"device is cuda:2, but torch .* finds 2 CUDA GPUs") as caught:
        pick_device("cuda:2", where="task.test")
    assert caught.value.faults[0].expected == "auto, cpu, cuda:0, cuda:1"


@pytest.mark.parametrize("name", ["auto", "cpu", "cuda", "cuda:11"])
def test_names_of_devices(name):
    assert re.fullmatch(DEVICE_PATTERN, name)


def test_random_numbers_come_from_the_generator_and_from_nowhere_else():
    def draw(seed: int) -> list[float]:
        with drawing_from(np.random.default_rng(seed)):
            return torch.rand(3).tolist()

    first = draw(1)
    torch.rand(5)
    assert draw(1) == first
    assert draw(2) != first


def test_torchs_own_generator_is_left_as_it_was():
    before = torch.random.get_rng_state()
    with drawing_from(np.random.default_rng(1)):
        torch.rand(3)
    assert torch.equal(torch.random.get_rng_state(), before)
