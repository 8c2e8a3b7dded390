"""The response of a camera: which light a code stands for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PLACES = ((0, 0), (0, 1), (1, 0), (1, 1))
_KNOTS = 256
_QUANTILES = np.linspace(0.005, 0.995, 400)
_LOWEST, _UNCLIPPED = 0.05, 0.985
"""Shares between which codes are used: of all, as noise widens the ranks of darker ones, and of the largest
of a colour, below which it is taken not to be clipped: coded, each colour has a largest code of its own."""
_SMOOTHNESS = 10.0
"""Weight of a change of the exponent from knot to knot, beside logarithms of ratios of light [1]."""


@dataclass(frozen=True, eq=False)
class Response:
    """Light over code at (K,) knots, both rising; linear between them [DN]."""

    code_dn: NDArray[np.float64]
    light_dn: NDArray[np.float64]

    def light(self, codes_dn: NDArray[np.uint16]) -> NDArray[np.float32]:
        """Linear light of codes, in the same shape [DN]."""
        table = np.interp(np.arange(int(codes_dn.max(initial=0)) + 1), self.code_dn, self.light_dn)
        return np.asarray(table.astype(np.float32)[codes_dn], np.float32)

    def codes(self, light_dn: NDArray[np.float32]) -> NDArray[np.uint16]:
        """Codes of linear light, rounded and clipped [DN]."""
        found = np.interp(light_dn, self.light_dn, self.code_dn)
        return np.rint(found).astype(np.uint16)

    def continued(self, other: Response, code_dn: float) -> Response:
        """This response up to a code, and from there on as another one rises [DN]."""
        here = float(np.interp(code_dn, self.code_dn, self.light_dn))
        there = float(np.interp(code_dn, other.code_dn, other.light_dn))
        own, beyond = self.code_dn < code_dn, other.code_dn > code_dn
        return Response(
            np.concatenate([self.code_dn[own], [code_dn], other.code_dn[beyond]]),
            np.concatenate([self.light_dn[own], [here], other.light_dn[beyond] * here / there]),
        )


def linear_response(white_dn: int) -> Response:
    """Response of raw samples."""
    ends = np.array([0.0, white_dn])
    return Response(ends, ends)


def tabled_response(values: NDArray[np.float64], white_dn: int) -> Response:
    """A response from a table of light at evenly spaced codes, in any unit.

    Raises ValueError when it has fewer than two values, or they do not rise.
    """
    if len(values) < 2 or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0) or values[-1] <= 0:
        raise ValueError(f"{len(values)} values that do not rise throughout")
    return Response(np.linspace(0, white_dn, len(values)), values * white_dn / values[-1])


def estimated_response(
    frames_dn: Mapping[float, NDArray[np.uint16]], white_dn: int, places: Sequence[tuple[int, int]] = PLACES
) -> Response:
    """The response under which one scene at several exposures has light in proportion to their times.

    Brightness ranks alike in all of them, so equal quantiles of their codes are of equal light: motion
    between the frames does no harm. Places of each 2 x 2 are ranked by themselves, as colours differ. The
    logarithm of the response is then a least-squares problem.

    - `frames_dn`: (N, H, W) codes by exposure time [DN]; two exposures or more.
    - `places`: (row, column) of the samples of each 2 x 2 that are used.

    Source: Debevec and Malik 1997, "Recovering high dynamic range radiance maps from photographs", eq. 3, on
    pairs of Grossberg and Nayar 2003, "Determining the camera response from images: what is knowable?".
    """
    times = sorted(frames_dn)
    knots_dn = np.linspace(0, white_dn, _KNOTS)
    rows, wanted = [], []
    for row, column in places:
        levels = {t: np.quantile(frames_dn[t][:, row::2, column::2], _QUANTILES) for t in times}
        low_dn, high_dn = _LOWEST * white_dn, _UNCLIPPED * max(level[-1] for level in levels.values())
        for i, short in enumerate(times):
            for long in times[i + 1 :]:
                valid = (levels[short] > low_dn) & (levels[long] < high_dn)
                for first, second in zip(levels[short][valid], levels[long][valid], strict=True):
                    rows.append(_hat(second, white_dn) - _hat(first, white_dn))
                    wanted.append(np.log(long / short))
    # Smooth in the exponent of a power law, so that neither a linear response nor a gamma is a bend.
    base = np.log(np.maximum(knots_dn, white_dn / _KNOTS / 2))
    exponents = np.diff(np.eye(_KNOTS), axis=0) / np.diff(base)[:, None]
    bends = _SMOOTHNESS * np.diff(exponents, axis=0)
    anchor = np.zeros((1, _KNOTS))
    anchor[0, -1] = 1e3
    matrix = np.concatenate([np.array(rows).reshape(-1, _KNOTS), bends, anchor])
    target = np.concatenate(
        [
            np.array(wanted) - np.array(rows).reshape(-1, _KNOTS) @ base,
            np.zeros(len(bends)),
            [-1e3 * base[-1]],
        ]
    )
    logarithm = base + np.linalg.lstsq(matrix, target, rcond=None)[0]
    light = np.exp(np.maximum.accumulate(logarithm + 1e-9 * np.arange(_KNOTS)))
    light[0] = min(light[0], light[1] / 2)
    return Response(knots_dn, light * white_dn / light[-1])


def _hat(code_dn: float, white_dn: int) -> NDArray[np.float64]:
    """(knots,) weights of the knots around a code."""
    weights = np.zeros(_KNOTS)
    place = code_dn / white_dn * (_KNOTS - 1)
    left = min(int(place), _KNOTS - 2)
    weights[left], weights[left + 1] = left + 1 - place, place - left
    return weights
