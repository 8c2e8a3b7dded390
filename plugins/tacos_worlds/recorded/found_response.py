"""The response of a recording: as told, as its exposures bear that out, or estimated from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault
from tacos_framework.files import read_text
from tacos_worlds.recorded.consistency import by_lamp
from tacos_worlds.recorded.recording import ExposedFrames
from tacos_worlds.recorded.response import Response, estimated_response, linear_response, tabled_response
from tacos_worlds.recorded.saturation import trusted_codes

ResponseFrom = Literal["recorded", "linear", "estimated"]

RESPONSE = "response.txt"
_STRONG_FLICKER = 0.3
"""Share of the light by which a lamp must waver to turn the order of exposures of a factor of two [1]."""

_CLOSE = 0.05
"""Disagreement of exposures up to which a told response is kept, where it has to be mended: what it is off by
there, all light beyond is off by [1]."""


@dataclass(frozen=True, eq=False)
class FoundResponse:
    """A response, and where it comes from in a sentence."""

    response: Response
    origin: str
    contradicted: Response | None = None  # the one that was told, where exposures contradict it in part
    trusted_dn: int | None = None  # code up to which they bear it out, there


def response_of(
    path: Path,
    fit: Mapping[str, ExposedFrames],
    bits: int,
    clipping_dn: NDArray[np.int64],
    wanted: ResponseFrom,
    faults: list[Fault],
    bad: set[float],
) -> FoundResponse | None:
    """The response of a folder's frames, told by a file or by its exposures; None where neither tells it.

    `faults`, `bad`: what is wrong, and the exposures it is wrong with [ms], are added.
    """
    file, white_dn = path / RESPONSE, (1 << bits) - 1
    if wanted == "linear":
        return FoundResponse(linear_response(white_dn), "The samples are taken to be linear.")
    if wanted == "recorded" and file.is_file():
        try:
            told = tabled_response(np.array(read_text(file).split(), np.float64), white_dn)
        except ValueError as error:
            faults.append(
                Fault(
                    str(file),
                    f"holds no response: {error}",
                    "numbers that rise",
                    "Take it out to have the response estimated.",
                )
            )
            return None
        return _borne_out(told, fit, clipping_dn)
    if len(fit) < 2:
        if not faults:
            faults.append(
                Fault(
                    str(path),
                    f"has no {RESPONSE} and one exposure",
                    "one of the two, to know the response",
                    "Say so where samples are linear.",
                )
            )
        return None
    brightness = [float(np.median(each.codes_dn)) for each in fit.values()]
    names = list(fit)
    fell = [i for i in range(1, len(names)) if brightness[i] < brightness[i - 1]]
    for i in fell:
        bad |= {fit[names[j]].exposure_ms for j in (i - 1, i)}
        faults.append(
            Fault(
                f"{path}: {names[i]} ms",
                f"is darker (median code {brightness[i]:.0f}) than {names[i - 1]} ms "
                f"({brightness[i - 1]:.0f})",
                "exposures that match the brightness",
                "Correct the exposures in the names of the files."
                + by_lamp(fit[names[i]].exposure_ms, _STRONG_FLICKER),
            )
        )
    if fell:
        return None
    stacks = {each.exposure_ms: each.codes_dn for each in fit.values()}
    said = "The response was estimated from the exposures themselves."
    return FoundResponse(estimated_response(stacks, white_dn), said)


def _borne_out(
    told: Response, fit: Mapping[str, ExposedFrames], clipping_dn: NDArray[np.int64]
) -> FoundResponse:
    """A told response as far as the exposures bear it out, and from there on what they make of it."""
    frames = {each.exposure_ms: each.codes_dn for each in fit.values()}
    said = f"The response is that of {RESPONSE}"
    if trusted_codes(frames, told, clipping_dn).min() == clipping_dn.min():
        return FoundResponse(told, f"{said}.")
    estimated = estimated_response(frames, int(told.code_dn[-1]))
    trusted_dn = int(trusted_codes(frames, told, clipping_dn, _CLOSE).min())
    said = f"{said} up to code {trusted_dn}, and that of the exposures beyond, where they contradict it."
    return FoundResponse(told.continued(estimated, trusted_dn), said, told, trusted_dn)
