"""``--device``: a GPU that is not there is refused before anything runs."""

from __future__ import annotations

import ctypes
from typing import Any

import pytest

from tacos_framework.cli.run import main
from tacos_framework.environment import DEVICE_VARIABLE, Gpu
from tacos_plugins import chosen_device

TWO = [Gpu(0, "First"), Gpu(1, "Second")]


@pytest.fixture(autouse=True)
def _nothing_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(DEVICE_VARIABLE, "")


@pytest.mark.parametrize(
    ("gpus", "said"),
    [
        (TWO, "there is no GPU 7\n  expected: cpu, or 0 (First), or 1 (Second)"),
        ([], "this machine has no GPU that can be used\n  expected: cpu\n"),
    ],
)
def test_a_gpu_that_is_not_there_is_told_with_other_faults(
    gpus: list[Gpu], said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(chosen_device, "gpus", lambda: gpus)
    assert main(["headset_quick", "--device", "7", "--set", "seed=-1", "--check"]) == 2
    error = capsys.readouterr().err
    assert f"--device 7: {said}" in error
    assert "seed is -1" in error


def test_a_gpu_of_the_environment_is_called_by_its_variable(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(chosen_device, "gpus", lambda: TWO)
    monkeypatch.setenv(DEVICE_VARIABLE, "7")
    assert main(["headset_quick", "--check"]) == 2
    assert "TACOS_DEVICE=7: there is no GPU 7\n" in capsys.readouterr().err


@pytest.mark.parametrize("device", ["cpu", "auto", "1", "cuda:0"])
def test_devices_that_are_there_are_no_fault(device: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chosen_device, "gpus", lambda: TWO)
    assert main(["headset_quick", "--device", device, "--check"]) == 0


def test_gpus_are_those_of_cuda_s_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    class Driver:
        """Answers as libcuda does: two GPUs, of which one has no name."""

        def cuInit(self, flags: int) -> int:
            return 0

        def cuDeviceGetCount(self, count: Any) -> int:
            count._obj.value = 2
            return 0

        def cuDeviceGet(self, device: Any, number: int) -> int:
            device._obj.value = number
            return 0

        def cuDeviceGetName(self, name: Any, size: int, device: Any) -> int:
            name.value = b"First"
            return device.value

    monkeypatch.setattr(ctypes, "CDLL", lambda _: Driver())
    assert chosen_device.gpus() == [Gpu(0, "First"), Gpu(1, "of unknown name")]


def test_without_cuda_s_driver_there_are_no_gpus(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(_: str) -> Any:
        raise OSError("no such library")

    monkeypatch.setattr(ctypes, "CDLL", absent)
    assert chosen_device.gpus() == []
