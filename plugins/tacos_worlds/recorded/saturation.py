"""Codes beyond which samples of a colour tell no light: they pile up there, or exposures contradict."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.recorded.response import Response

_BINS = 256
_BELOW = slice(-12, -4)
"""Bins beside the pile: so near that a bright sky, which is wider, does not rise over them as a pile does."""
_PILE = 3.0
"""Samples in the fullest bin of a pile over those in the bins below it, at least."""
_LOWEST = 0.9
"""Share of the largest code from which a pile is the sensor's: makers match its range to the codes."""
_BEYOND = 0.01
"""Share of samples beyond a pile: noise spreads it, and light reaches no further."""
_RANKS = 1 - np.geomspace(0.5, 3e-4, 48)
_AGREEMENT = 0.15
"""Light of one rank in two exposures may differ so much from the ratio of their times: as much as whole
exposures may, before they are refused [1]."""


def clipping_codes(codes_dn: NDArray[np.uint16], white_dn: int) -> NDArray[np.int64]:
    """(2, 2) codes from which samples are clipped, for each place of the 2 x 2 of a mosaic [DN].

    Photosites fill up below the largest code where gain is low or colours are balanced, and each colour at
    a code of its own. There samples of different light pile up. Without a pile only the largest code is
    clipped. White things of even light pile up, too: below nine tenths of the codes they are taken for such.

    `codes_dn`: (N, H, W) frames of the brightest exposure [DN].
    """
    return np.array(
        [[_onset(codes_dn[:, row::2, column::2], white_dn) for column in (0, 1)] for row in (0, 1)]
    )


def trusted_codes(
    frames_dn: Mapping[float, NDArray[np.uint16]],
    response: Response,
    clipping_dn: NDArray[np.int64],
    agreement: float = _AGREEMENT,
) -> NDArray[np.int64]:
    """(2, 2) codes up to which exposures agree on the light, at most those of clipping [DN].

    Brightness ranks alike in all exposures, so light of one rank is in proportion to their times, or the
    response is wrong there.

    - `frames_dn`: (N, H, W) codes by exposure time.
    - `agreement`: by how much light of one rank may differ from the ratio of the times [1].
    """
    trusted = clipping_dn.copy()
    for short, long in pairwise(sorted(frames_dn)):
        for row, column in np.ndindex(2, 2):
            darker, codes = (_at_ranks(frames_dn[t][:, row::2, column::2]) for t in (short, long))
            ratio = np.interp(codes, response.code_dn, response.light_dn) / np.maximum(
                np.interp(darker, response.code_dn, response.light_dn), 1e-9
            )
            agree = np.abs(ratio * short / long - 1) <= agreement
            told = codes < clipping_dn[row, column]
            if (agree & told).any() and (beyond := codes[told][np.flatnonzero(agree[told])[-1] + 1 :]).any():
                trusted[row, column] = min(trusted[row, column], beyond[0])
    return trusted


def _at_ranks(codes_dn: NDArray[np.uint16]) -> NDArray[np.int64]:
    return np.searchsorted(np.cumsum(np.bincount(codes_dn.ravel())), _RANKS * codes_dn.size)


def _onset(codes_dn: NDArray[np.uint16], white_dn: int) -> int:
    bins = min(_BINS, white_dn + 1)
    counts = np.bincount((codes_dn.astype(np.int64) * bins // (white_dn + 1)).ravel(), minlength=bins)
    beyond = np.cumsum(counts[::-1])[::-1]
    for fullest in range(bins - 1, int(_LOWEST * bins), -1):
        below = float(np.median(counts[fullest + _BELOW.start : fullest + _BELOW.stop]))
        if counts[fullest] < counts[fullest - 1] or counts[fullest] < _PILE * below + 5 * np.sqrt(below + 1):
            continue
        first = last = fullest
        while counts[first - 1] > 2 * below:
            first -= 1
        while last + 1 < bins and counts[last + 1] > below / 10:
            last += 1
        rest = beyond[last + 1] if last + 1 < bins else 0
        if last - first < -_BELOW.start and rest <= _BEYOND * (beyond[first] - rest):
            return -(-first * (white_dn + 1) // bins)
    return white_dn
