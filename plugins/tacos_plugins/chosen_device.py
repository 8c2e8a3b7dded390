"""The device that computes and renders: one choice for networks and pictures (`tacos-run --device`)."""

from __future__ import annotations

import ctypes
import os
from contextlib import suppress
from typing import Literal

from tacos_framework import DEVICE_VARIABLE, Fault, Gpu, UserError


def chosen_device() -> int | Literal["cpu"] | None:
    """The number of a GPU as CUDA counts them, ``cpu``, or None where nothing is chosen.

    Raises `UserError` when the environment variable ``TACOS_DEVICE`` says something else.
    """
    given = os.environ.get(DEVICE_VARIABLE, "")
    if given in ("", "auto"):
        return None
    if given == "cpu":
        return "cpu"
    number = given.removeprefix("cuda:")
    if number.isascii() and number.isdecimal():
        return int(number)
    raise UserError(
        Fault(
            "--device",
            f"{given!r} is no device",
            "cpu, or the number of a GPU: 0, 1, ...",
            "See nvidia-smi -L.",
        )
    )


_MOST_LETTERS = 128
"""Of a GPU's name."""


def gpus() -> list[Gpu]:
    """The GPUs as CUDA's driver counts them, which networks and pictures go by; none without the driver."""
    for library in ("libcuda.so.1", "libcuda.so", "nvcuda.dll"):
        with suppress(OSError):
            return _counted_by(ctypes.CDLL(library))
    return []


def _counted_by(driver: ctypes.CDLL) -> list[Gpu]:
    count, name = ctypes.c_int(), ctypes.create_string_buffer(_MOST_LETTERS)
    if driver.cuInit(0) != 0 or driver.cuDeviceGetCount(ctypes.byref(count)) != 0:
        return []
    found = []
    for number in range(count.value):
        device = ctypes.c_int()
        known = driver.cuDeviceGet(ctypes.byref(device), number) == 0
        known = known and driver.cuDeviceGetName(name, _MOST_LETTERS, device) == 0
        found.append(Gpu(number, name.value.decode(errors="replace") if known else "of unknown name"))
    return found
