"""The affine noise model and how it carries over to other gains, pixels and binnings.

A calibrated camera has, at gain G0 and with photosites of pitch p0, the variance

    var(I) = s_p I + s_t                      (supplement, Sec. Noise Model Calibration)

for a mean signal I above black: photon (shot) noise grows with the signal, thermal noise does not. Another
gain G multiplies both signal and noise, and a photosite of another area acts as a gain in inverse proportion
to that area, since equal intensities take less gain where more photons are caught:

    r      = (p0^2 / p^2) (G / G0)
    var(I) = r s_p I + r^2 s_t                (eq. 1)

In this model a larger photosite is always better: it knows no full well, no quantum efficiency, no dark
current, and larger optics cost nothing.

Source: the paper, Sec. 3.1 and supplement; Foi et al. 2008, "Practical Poissonian-Gaussian noise modeling and
fitting for single-image raw-data", IEEE Trans. Image Processing 17(10).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.camera import gain_factor
from tacos_plugins.sensors.gaussian import PLACES, NormalNumbers
from tacos_plugins.sensors.kept_numbers import KeptNumbers

_AT_ONCE = 1 << 20
"""Samples drawn in one go: each of many small steps would have threads wait for one another."""

_RUN = 1 << 12
"""Samples about, along which each channel's figures are repeated: numpy is ten times slower over three."""


def gain_ratio(
    gain_db: float, pixel_um: float, *, calibrated_gain_db: float, calibrated_pixel_um: float
) -> float:
    """The ratio r that carries a noise calibration over to another gain and photosite.

    - `gain_db`: gain of the scenario, as set on the calibrated photosite [dB].
    - `pixel_um`: pitch of the photosites [um].
    - `calibrated_gain_db`: gain of the calibration, G0 [dB].
    - `calibrated_pixel_um`: pitch of the calibrated photosites, p0 [um].

    Returns: r [1].

    Flea3 (1.55 um) calibrated at 15 dB:

    >>> round(gain_ratio(5, 1.55, calibrated_gain_db=15, calibrated_pixel_um=1.55), 4)
    0.3162
    >>> round(gain_ratio(15, 3.10, calibrated_gain_db=15, calibrated_pixel_um=1.55), 4)
    0.25
    """
    return (calibrated_pixel_um / pixel_um) ** 2 * gain_factor(gain_db - calibrated_gain_db)


def affine_variance(
    signal_dn: ArrayLike,
    photon_dn: ArrayLike,
    thermal_dn2: ArrayLike,
    *,
    ratio: float = 1.0,
    photosites: float = 1.0,
) -> NDArray[np.float64]:
    """Variance of the noise on a mean signal (eq. 1), before rounding and clipping.

    - `signal_dn`: mean signal above black; below black counts as black [DN].
    - `photon_dn`: s_p of the calibration: variance per digital number of signal [DN].
    - `thermal_dn2`: s_t of the calibration: variance without signal [DN^2].
    - `ratio`: r of :func:`gain_ratio` [1].
    - `photosites`: how many photosites with independent noise are averaged into one sample; divides the
      variance [1].

    Returns: variance; the arguments broadcast [DN^2].

    Green of the Flea3 at 5 dB and half of full scale, for three pitches:

    >>> for pixel_um in (1.55, 3.45, 6.6):
    ...     r = gain_ratio(5, pixel_um, calibrated_gain_db=15, calibrated_pixel_um=1.55)
    ...     print(round(signal_to_noise_db(128, affine_variance(128, 0.12, 0.91, ratio=r)).item(), 1))
    35.2
    42.2
    47.9
    """
    signal = np.maximum(np.asarray(signal_dn, dtype=np.float64), 0.0)
    photon = ratio * np.asarray(photon_dn, dtype=np.float64)
    thermal = ratio**2 * np.asarray(thermal_dn2, dtype=np.float64)
    return (photon * signal + thermal) / photosites


def signal_to_noise_db(signal_dn: ArrayLike, variance_dn2: ArrayLike) -> NDArray[np.float64]:
    """Signal-to-noise ratio, 20 log10(mean / standard deviation) [dB].

    >>> signal_to_noise_db(100.0, 1.0).item()
    40.0
    """
    return 20 * np.log10(np.asarray(signal_dn) / np.sqrt(variance_dn2))


def add_noise(
    samples_dn: NDArray[np.float32],
    out: NDArray[np.float32],
    *,
    black_level_dn: float,
    photon_dn: NDArray[np.float32],
    thermal_dn2: NDArray[np.float32],
    rng: np.random.Generator,
    kept: KeptNumbers | None = None,
) -> None:
    """Write samples with Gaussian noise of affine variance into `out`.

    A Poisson variable of many electrons is Gaussian to the accuracy of the model; the sum of both noises is
    drawn at once.

    - `samples_dn`: (..., W, C) expected samples, pedestal included [DN].
    - `out`: where the noisy samples go; same shape, C-contiguous float32, not `samples_dn` itself [DN].
    - `black_level_dn`: pedestal [DN].
    - `photon_dn`, `thermal_dn2`: (C,) or scalar variance per signal, and without signal, of one sample: ratio
      and photosites already applied [DN, DN^2].
    - `rng`: draws the key of this frame's numbers; they then follow from the places of the samples.
    - `kept`: remembers them, where frames are drawn again and again.
    """
    from tacos_plugins.sensors.sample_loops import add_scaled

    if not out.flags.c_contiguous:
        raise ValueError("noise can be written into a contiguous array only")
    channels = samples_dn.shape[-1]
    pixels = max(PLACES, _RUN // channels // PLACES * PLACES)
    photon = np.tile(np.broadcast_to(photon_dn, channels), pixels)
    thermal = np.tile(np.broadcast_to(thermal_dn2, channels), pixels)
    without_signal = thermal - photon * np.float32(black_level_dn)
    expected, noisy = samples_dn.reshape(-1), out.reshape(-1)
    normal = NormalNumbers(rng) if kept is None else kept.of(rng, len(expected))
    step = max(_AT_ONCE // len(photon), 1) * len(photon)
    for start in range(0, len(expected), step):
        drawn = noisy[start : start + step]
        normal.fill(drawn)
        add_scaled(expected[start : start + step], photon, without_signal, thermal, drawn)
