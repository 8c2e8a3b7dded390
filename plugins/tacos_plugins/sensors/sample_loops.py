"""Loops over the samples of a frame, compiled; imported late, as numba takes a while."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_framework.compiled import compiled


@compiled
def look_up(
    bins: NDArray[np.uint16],
    table: NDArray[np.float32],
    tail_bins: int,
    out: NDArray[np.float32],
    tail: NDArray[np.int64],
) -> int:
    """Look numbers up in a table, and note which are of its ends.

    Parameters
    ----------
    bins
        (N,) places in the table.
    table
        (65 536,) float32.
    tail_bins
        How many places at each end belong to the tails.
    out
        (N,) is filled.
    tail
        (N + 1,) its beginning is filled with the numbers of those samples, in their order.

    Returns
    -------
    How many there are.
    """
    count = 0
    for sample in range(len(bins)):
        place = bins[sample]
        out[sample] = table[place]
        tail[count] = sample  # written always, and counted where it is one: there is no branch to guess
        count += (place < tail_bins) | (place >= len(table) - tail_bins)
    return count


@compiled
def add_scaled(
    expected: NDArray[np.float32],
    photon: NDArray[np.float32],
    without_signal: NDArray[np.float32],
    thermal: NDArray[np.float32],
    noisy: NDArray[np.float32],
) -> None:
    """Scale normal numbers to the noise of samples, and add the samples, in place.

    Parameters
    ----------
    expected
        (N,) samples, pedestal included [DN].
    photon, without_signal, thermal
        (P,) again and again along the samples: variance per digital number of a sample, that of a sample of 0
        on the same line, and the least, which is that of black [DN, DN^2, DN^2].
    noisy
        (N,) normal numbers, which become the noisy samples [DN].
    """
    for start in range(0, len(expected), len(photon)):
        samples, numbers = expected[start : start + len(photon)], noisy[start : start + len(photon)]
        for place in range(len(samples)):
            variance = max(samples[place] * photon[place] + without_signal[place], thermal[place])
            numbers[place] = numbers[place] * np.sqrt(variance) + samples[place]
