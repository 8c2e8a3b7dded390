"""From the luminance of a scene to the light on a sensor, and from analog samples to file values."""

from __future__ import annotations

import math

TYPICAL_ROW_TIME_US = 15.0
"""Median over 24 rolling-shutter sensors of robots, phones and cars whose line time follows from the
registers that Linux drivers write, at full resolution; 4.9 to 52 us [us]."""


def gain_factor(gain_db: float) -> float:
    """Gain as a factor on the signal; 20 dB is a factor of 10 [1].

    >>> gain_factor(20.0)
    10.0
    """
    return 10 ** (gain_db / 20)


def exposure_per_luminance(time_s: float, f_number: float) -> float:
    """The focal-plane exposure that one cd/m2 makes.

    On the optical axis of a lens without losses, focused far away, a luminance L lights the sensor with
    E = pi L / (4 N^2) [lux], and for a time t the exposure is H = E t. Fall-off towards the corners and
    losses in the glass are effects, not part of this.

    `time_s`: exposure time [s]. `f_number`: focal length over aperture diameter [1].

    Returns: H / L [lux s / (cd/m2)].

    Source: ISO 12232, Annex A, with transmittance and vignetting of 1.

    >>> luminance = 20.0 * 0.8 / math.pi  # of a matte white wall that 20 lux fall on
    >>> round(luminance * exposure_per_luminance(time_s=0.030, f_number=2.0), 6)
    0.03
    """
    return math.pi * time_s / (4 * f_number**2)
