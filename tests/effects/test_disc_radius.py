"""How wide a disc has blurred a picture."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_plugins.effects.blur import disc_transfer
from tacos_plugins.effects.disc_radius import _passed_by_disc


@pytest.mark.parametrize(("height", "width"), [(48, 64), (47, 65), (1, 2)])
@pytest.mark.parametrize("radius_px", [0.3, 4.7])
def test_a_quarter_of_the_frequencies_tells_all_to_the_bit(height, width, radius_px):
    fx, fy = np.fft.fftfreq(width), np.fft.fftfreq(height)
    wanted = disc_transfer(radius_px)(fx[None, :], fy[:, None]) ** 2
    np.testing.assert_array_equal(_passed_by_disc(radius_px, fx, fy), wanted)
