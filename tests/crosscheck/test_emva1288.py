"""sensor.emva against `emva1288`, an independent implementation of the standard by its authors.

Both ways: its evaluation of our images must find the figures that went in, and its camera simulator must make
images of the same mean and variance as ours. The package is licensed under the GPL and is used by these tests
alone.
"""

from __future__ import annotations

import logging

import numpy as np
import pytest

from tacos_framework.testing.forming import expose
from tacos_framework.values import Camera, Electrons, Exposure
from tacos_plugins.sensors.emva import Emva
from tests.small_worlds import captured_light

pytest.importorskip("emva1288", reason="install the extra `crosscheck` for the independent EMVA 1288")

EXPOSURE = Exposure(time_s=0.020, f_number=8.0, gain_db=0.0)
TRUTH = Electrons(
    "test", quantum_efficiency=0.55, full_well_e=9000.0, read_noise_e=4.0, dark_current_e_s=100.0
)
CAMERA = Camera("camera", 256, 192, pixel_um=3.45, focal_length_mm=8.0, electrons=TRUTH)
BLACK_DN, BIT_DEPTH = 64.0, 12
GAIN_DN_PER_E = (2**BIT_DEPTH - 1 - BLACK_DN) / TRUTH.full_well_e


def our_frames(photons: float, *, frames: int, seed: int) -> np.ndarray:
    """Frames of evenly lit photosites that receive so many photons on average."""
    sensor = Emva(Emva.Config(channels="mono", bit_depth=BIT_DEPTH, black_level_dn=BLACK_DN))
    per_photon = TRUTH.quantum_efficiency / sensor.electrons_per_luminance(CAMERA, EXPOSURE)
    capture = captured_light(CAMERA, photons * per_photon, frames)
    return expose(sensor, capture, exposure=EXPOSURE, seed=seed).images[0][..., 0]


@pytest.fixture
def numpy_of_old(monkeypatch: pytest.MonkeyPatch) -> None:
    """emva1288 1.0 calls a function that numpy 2 has dropped."""
    monkeypatch.setattr(np, "asfarray", lambda a: np.asarray(a, dtype=float), raising=False)


@pytest.mark.usefixtures("numpy_of_old")
def test_its_evaluation_of_our_images_finds_the_figures_that_went_in():
    from emva1288.process.data import Data1288
    from emva1288.process.results import Results1288
    from emva1288.process.routines import get_int_imgs

    def sums(photons: float, frames: int, seed: int) -> dict:
        return get_int_imgs(list(our_frames(photons, frames=frames, seed=seed)))

    def totals(photons: float, seed: int) -> dict:
        of_two = sums(photons, 2, seed)
        return {"sum": of_two["sum"].sum(), "pvar": of_two["pvar"].sum(), "dmean": of_two["dmean"]}

    saturation = TRUTH.full_well_e / TRUTH.quantum_efficiency
    steps = np.linspace(0.0, 1.08, 55) * saturation
    data = {
        "width": CAMERA.width_px,
        "height": CAMERA.height_px,
        "temporal": {2e7: {float(photons): totals(photons, seed) for seed, photons in enumerate(steps)}},
        "spatial": {2e7: {0.0: sums(0.0, 8, 90), saturation / 2: sums(saturation / 2, 8, 91)}},
    }
    evaluated = Data1288(data, loglevel=logging.ERROR).data
    found = Results1288(evaluated, pixel_area=CAMERA.pixel_um**2, loglevel=logging.ERROR)
    figures = {
        "K": (found.K, GAIN_DN_PER_E, 0.01),
        "QE": (found.QE / 100, TRUTH.quantum_efficiency, 0.01),
        "dark noise": (found.sigma_d, np.hypot(TRUTH.read_noise_e, np.sqrt(100.0 * 0.020)), 0.02),
        "full well": (found.u_e_sat, TRUTH.full_well_e, 0.05),
        "SNR max": (found.SNR_max, np.sqrt(TRUTH.full_well_e), 0.03),
    }
    for name, (got, truth, tolerance) in figures.items():
        print(f"{name}: found {got:.5g}, went in {truth:.5g} ({got / truth - 1:+.2%})")
        assert got == pytest.approx(truth, rel=tolerance), name
    assert abs(found.LE_max) < 1.0  # percent off the straight line


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_its_camera_makes_images_of_the_same_mean_and_variance(share):
    """In the dark it cannot be compared: it stops the noise of reading at an empty well."""
    from emva1288.camera.camera import Camera as Camera1288
    from emva1288.camera.routines import Qe, get_radiance

    photons = share * TRUTH.full_well_e / TRUTH.quantum_efficiency
    size = (CAMERA.height_px, CAMERA.width_px)
    wavelength = np.array([555.0])
    theirs = Camera1288(
        f_number=EXPOSURE.f_number,
        pixel_area=CAMERA.pixel_um**2,
        bit_depth=BIT_DEPTH,
        width=CAMERA.width_px,
        height=CAMERA.height_px,
        temperature=30,
        qe=Qe(np.full((*size, 1), TRUTH.quantum_efficiency), wavelength, CAMERA.width_px, CAMERA.height_px),
        exposure=EXPOSURE.time_s * 1e9,
        K=GAIN_DN_PER_E,
        K_min=GAIN_DN_PER_E,
        K_max=GAIN_DN_PER_E,
        K_steps=1,
        blackoffset=BLACK_DN,
        blackoffset_min=BLACK_DN,
        blackoffset_max=BLACK_DN,
        blackoffset_steps=1,
        dark_current_ref=TRUTH.dark_current_e_s,
        dark_signal_0=0.0,
        sigma2_dark_0=TRUTH.read_noise_e**2,
        u_esat=TRUTH.full_well_e,
        seed=1,
    )
    up = np.full((*size, 1), photons)
    radiance = get_radiance(EXPOSURE.time_s * 1e9, up, CAMERA.pixel_um**2, EXPOSURE.f_number, wavelength)
    image = theirs.grab(radiance).astype(float)
    ours = our_frames(photons, frames=2, seed=3).astype(float)
    standard_error = image.std() / np.sqrt(image.size)
    assert ours.mean() == pytest.approx(image.mean(), abs=5 * standard_error)
    # Theirs rounds a value to which it has added the rounding error already: 1/12 DN^2 twice.
    assert ours.var() == pytest.approx(image.var() - 1 / 12, rel=0.03)
    print(f"{share:.0%}: ours {ours.mean():.2f} DN, {ours.var():.2f} DN^2; "
          f"theirs {image.mean():.2f} DN, {image.var():.2f} DN^2")  # fmt: skip
