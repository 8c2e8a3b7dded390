"""Loops over the samples of a frame, compiled; imported late, as numba takes a while."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tacos_plugins.compiled.loops import compiled, unaliased


@unaliased
def look_up(bins: NDArray[np.uint16], table: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """Fill (N,) with numbers of a table of 65 536, by their places in it."""
    for sample in range(len(bins)):
        out[sample] = table[np.uint32(bins[sample])]


@unaliased
def find_tails(words: NDArray[np.uint64], tail_bits: int, count: int, tail: NDArray[np.int64]) -> int:
    """Note which samples lie at an end of the table of their places.

    - `words`: places of 16 bits, four to a word, the first in the lowest.
    - `tail_bits`: those at an end begin with 16 - `tail_bits` equal bits.
    - `count`: how many samples there are; what is beyond them in the last word is none.
    - `tail`: (N,) its beginning is filled with the numbers of those samples, in their order.

    Returns: how many there are.
    """
    found = 0
    ones = np.uint64(0x0001000100010001)
    highest = ones << np.uint64(15)
    begins = (np.uint64(0xFFFF) >> np.uint64(tail_bits)) * ones
    for number in range(len(words)):
        # The bits that places begin with are all 0, or all 1, where taking 1 away borrows from above.
        low = (words[number] >> np.uint64(tail_bits)) & begins
        high = low ^ begins
        if ((low - ones) & ~low & highest) | ((high - ones) & ~high & highest):
            for part in range(4):
                place = (low >> np.uint64(16 * part)) & np.uint64(0xFFFF)
                sample = 4 * number + part
                at_an_end = (place == 0) | (place == begins & np.uint64(0xFFFF))
                if at_an_end and sample < count:
                    tail[found] = sample
                    found += 1
    return found


@compiled
def add_scaled(
    expected: NDArray[np.float32],
    photon: NDArray[np.float32],
    without_signal: NDArray[np.float32],
    thermal: NDArray[np.float32],
    noisy: NDArray[np.float32],
) -> None:
    """Scale normal numbers to the noise of samples, and add the samples, in place.

    - `expected`: (N,) samples, pedestal included [DN].
    - `photon`, `without_signal`, `thermal`: (P,) again and again along the samples: variance per digital
      number of a sample, that of a sample of 0 on the same line, and the least, which is that of black [DN,
      DN^2, DN^2].
    - `noisy`: (N,) normal numbers, which become the noisy samples [DN].
    """
    for start in range(0, len(expected), len(photon)):
        samples, numbers = expected[start : start + len(photon)], noisy[start : start + len(photon)]
        for place in range(len(samples)):
            variance = max(samples[place] * photon[place] + without_signal[place], thermal[place])
            numbers[place] = numbers[place] * np.sqrt(variance) + samples[place]
