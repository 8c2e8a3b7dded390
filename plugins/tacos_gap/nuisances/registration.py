"""Registration: shift, turn and magnification of a picture against its expectation, from the pictures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import RealCapture
from tacos_gap.nuisances.freedom import Freedom
from tacos_plugins.effects.alignment import aligned_with_expected


def registered(capture: RealCapture, freedoms: Sequence[Freedom]) -> NDArray[np.float64]:
    """(F,) nuisances of pose that align the expectation with the mean frame best, the others 0.

    An affine map is fitted, so that what shears the picture turns no one's camera. All are 0 where no
    alignment is found.
    """
    nu = np.zeros(len(freedoms))
    names = [freedom.name for freedom in freedoms]
    if "shift_x_px" not in names:
        return nu
    matrix = aligned_with_expected(capture)
    if matrix is None:
        return nu
    centre = np.asarray(capture.geometry.centre_px, float)
    linear = matrix[:, :2]
    shift = linear @ centre + matrix[:, 2] - centre
    found = {
        "shift_x_px": shift[0],
        "shift_y_px": shift[1],
        "rotation_deg": np.degrees((linear[1, 0] - linear[0, 1]) / 2),
        "scale": (linear[0, 0] + linear[1, 1]) / 2 - 1,
    }
    for name, value in found.items():
        nu[names.index(name)] = value / freedoms[names.index(name)].sigma
    return nu
