"""The electron model of EMVA 1288: light to photons, to electrons, to digital numbers.

A photosite of area A behind a lens of f-number N, which faces a luminance L for a time t, collects

    mu_p = Phi A H,    H = pi L t / (4 N^2)                       photons
    mu_e = eta mu_p + mu_d,    mu_d = I_d t                        electrons (EMVA 1288, eq. 1 to 3)

with eta the quantum efficiency and I_d the dark current. Electrons are counted, so their number is Poisson
distributed; it ends at the full well. The read noise adds, the system gain K makes digital numbers of it, and
rounding adds 1/12 DN^2:

    mu_y  = black + K mu_e
    var_y = K mu_e + K^2 sigma_d^2 + 1/12                          (EMVA 1288, eq. 13: the photon transfer)

so that SNR is at most the square root of the full well.

Luminance weighs light as the eye does, so photons per lux depend on the spectrum. `PHOTONS_PER_LUX_S_UM2`
holds two: CIE daylight, D65, cut to 400 .. 700 nm as behind an infrared filter, and light of 555 nm alone. A
quantum efficiency goes with the first as the mean over the photons of that spectrum, with the second as the
value at 555 nm.

Sources: EMVA Standard 1288, Release 4.0 Linear, 2021, Sec. 2; CIE 018:2019 (683 lm/W); ISO/CIE 11664-2 (D65).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tacos_framework.camera import exposure_per_luminance, gain_factor

Spectrum = Literal["daylight", "green-555nm"]
"""The light that stands for what the scene sends; see :data:`PHOTONS_PER_LUX_S_UM2`."""

PHOTONS_PER_LUX_S_UM2: Mapping[Spectrum, float] = MappingProxyType(
    {"daylight": 10880.1, "green-555nm": 4090.67}
)
"""Photons per lux second and square micrometre.

``daylight``: sum of S(w) w / (h c) over 400 .. 700 nm, over 683 lm/W times the sum of S(w) V(w), with S the
CIE table of D65 and V the photopic observer of 1924. ``green-555nm``: w / (h c) / (683 lm/W) at 555 nm.
"""


def photons_per_luminance(
    *, time_s: float, f_number: float, pixel_um: float, spectrum: Spectrum = "daylight"
) -> float:
    """Photons that one cd/m2 sends to a photosite.

    - `time_s`: exposure time [s].
    - `f_number`: focal length over aperture diameter [1].
    - `pixel_um`: pitch of the photosites; the whole area counts, as quantum efficiency includes the fill
      factor [um].

    Returns: mu_p / L [1 / (cd/m2)].

    A white wall (reflectance 0.8) at 20 lux, f/2, 30 ms, on a pixel of 3.45 um:

    >>> import math
    >>> luminance = 0.8 * 20 / math.pi
    >>> round(luminance * photons_per_luminance(time_s=0.030, f_number=2.0, pixel_um=3.45))
    3885
    """
    return PHOTONS_PER_LUX_S_UM2[spectrum] * pixel_um**2 * exposure_per_luminance(time_s, f_number)


def system_gain(full_well_e: float, range_dn: float, gain_db: float) -> float:
    """System gain K of a camera whose full well just fills the range of its files at 0 dB.

    - `full_well_e`: electrons a photosite holds [e-].
    - `range_dn`: white level less black level [DN].
    - `gain_db`: gain of the camera; above 0 dB its files are full before its photosites are [dB].

    Returns: K [DN/e-].

    >>> system_gain(10_000, 250, gain_db=20.0)
    0.25
    """
    return gain_factor(gain_db) * range_dn / full_well_e


def photon_transfer_variance(
    signal_dn: ArrayLike, gain_dn_per_e: float, read_noise_e: float, *, photosites: float = 1.0
) -> NDArray[np.float64]:
    """Variance of one sample below saturation, before rounding (EMVA 1288, eq. 13).

    - `signal_dn`: mean signal above black, dark signal included [DN].
    - `gain_dn_per_e`: system gain K [DN/e-].
    - `read_noise_e`: standard deviation without light [e-].
    - `photosites`: how many photosites are averaged into one sample [1].

    Returns: variance; affine in the signal, with the slope K [DN^2].

    >>> photon_transfer_variance([0.0, 100.0], 0.5, 4.0).tolist()
    [4.0, 54.0]
    """
    signal = np.asarray(signal_dn, dtype=np.float64)
    return (gain_dn_per_e * signal + (gain_dn_per_e * read_noise_e) ** 2) / photosites


def count_electrons(
    expected_e: NDArray[np.floating],
    *,
    full_well_e: float,
    read_noise_e: float,
    rng: np.random.Generator,
    photosites: float | NDArray[np.float64] = 1.0,
    photon_scale: float = 1.0,
) -> NDArray[np.float32]:
    """Electrons that are read from photosites: counted, limited by the full well, read with noise.

    - `expected_e`: mean electrons per photosite, dark signal included; below zero nothing is counted, and the
      value is kept as an offset [e-].
    - `full_well_e`: electrons a photosite holds [e-].
    - `read_noise_e`: standard deviation of the noise of reading one photosite [e-].
    - `rng`: draws a count and a normal number per sample.
    - `photosites`: how many photosites are averaged into one sample; need not be whole, may differ by channel
      [1].
    - `photon_scale`: factor on the variance of the counts, which leaves their mean alone [1].

    Returns: same shape, float32 [e-].

    >>> rng = np.random.default_rng(1)
    >>> read = count_electrons(np.full(100_000, 400.0), full_well_e=1e4, read_noise_e=5.0, rng=rng)
    >>> round(float(read.mean())), round(float(read.var()), -1)  # 400 and 400 + 5^2, but for chance
    (400, 420.0)
    """
    expected = np.asarray(expected_e, dtype=np.float64)
    light = np.maximum(expected, 0.0)
    if photon_scale > 0:
        step = photon_scale / photosites
        collected = rng.poisson(light / step) * step
    else:
        collected = light
    collected = np.minimum(collected, full_well_e) + np.minimum(expected, 0.0)
    noise = rng.standard_normal(expected.shape, dtype=np.float32)
    noise *= np.asarray(read_noise_e / np.sqrt(photosites), np.float32)
    noise += collected
    return noise
