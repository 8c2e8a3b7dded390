"""Which device computes and renders: one choice for networks and pictures (`tacos-run --device`)."""

from __future__ import annotations

import os
from typing import Literal

from tacos_framework.environment import DEVICE_VARIABLE
from tacos_framework.errors import Fault, UserError


def chosen_device() -> int | Literal["cpu"] | None:
    """The number of a GPU as CUDA counts them, ``cpu``, or None where nothing is chosen.

    Raises
    ------
    UserError
        When the environment variable ``TACOS_DEVICE`` says something else.
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
