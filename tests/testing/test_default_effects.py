"""The default effects pass the suite that third parties are given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tacos_framework import Component
from tacos_framework.testing import EffectConformance
from tacos_plugins.plugin import tacos_components

SETTINGS = {
    "auto-exposure": {
        "": {"target_mlx_s": 15.0, "lag_frames": 2.0},
        "AgainstTheFirstFrame": {"strength": 0.5, "first": 1.5, "lag_frames": 2.0},
    },
    "auto-white-balance": {"": {"red_first": 1.3, "blue_first": 0.8, "lag_frames": 2.0}},
    "black-level": {"": {"offset_dn": 3.0}},
    "colour-matrix": {"": {"matrix": ((1.6, -0.4, -0.2), (-0.3, 1.5, -0.2), (0.0, -0.6, 1.6))}},
    "conversion-gain-error": {"": {"scale": 1.3}},
    "conversion-gain-mode": {"": {"noise_scale": 0.5}},
    "crosstalk": {"": {"share": 0.02}},
    "dark-current": {"": {"rate_dn_s": 100.0, "hot_share": 0.01}},
    "defect-lines": {"": {"column_share": 0.1, "row_share": 0.05, "offset_dn": 8.0}},
    "defocus": {"": {"radius_px": 2.5}, "OnTheSensor": {"radius_um": 7.5}, "ByDepth": {"focus_m": 0.5}},
    "demosaic": {"": {"method": "bilinear"}},
    "denoise": {"": {"strength": 1.0}},
    "dsnu": {"": {"sigma_dn": 1.0, "column_sigma_dn": 1.0}},
    "exposure-error": {"": {"scale": 1.3}},
    "flicker": {"": {"depth": 0.3, "period_rows": 20.0}},
    "focal-length-error": {"": {"scale": 1.05, "dx_px": 1.5, "dy_px": -0.5}},
    "illumination-gradient": {"": {"gx": 0.2, "gy": -0.1}},
    "jpeg": {"": {"quality": 70}},
    "lateral-chromatic-aberration": {"": {"red": 0.004, "blue": -0.003, "red_r2": 0.002}},
    "lens": {"": {"wavelength_nm": 550.0, "focus_m": 0.3, "out_of_focus": 1.0, "fall_off": 1.0}},
    "lens-blur": {"": {"sigma_px": 1.2, "growth": 0.8}, "ByDiffraction": {"wavelength_nm": 2000.0}},
    "lens-distortion": {
        "": {"k1": -0.1, "k2": 0.02, "p1": 0.003},
        "Fisheye": {"model": "fisheye", "k1": 0.05},
    },
    "lens-shading-correction": {"": {"k1": 1.0}},
    "motion": {"": {"amount": 2.0, "shutter": "rolling", "row_time_us": 300.0}},
    "motion-blur": {"": {"length_px": 5.0, "angle_deg": 30.0}},
    "nonlinearity": {"": {"a2": -0.1}},
    "pose-error": {
        "": {"rx": 1.0, "ry": -0.5, "rz": 2.0},
        "WithAShift": {"tx": 100.0, "tz": 50.0},
    },
    "prnu": {"": {"sigma": 0.02}},
    "quantisation": {"": {"step_dn": 4.0}},
    "read-noise": {"": {"sigma_dn": 1.0, "tail": 0.2}, "InElectrons": {"sigma_e": 12.0}},
    "rolling-shutter": {"": {"row_time_us": 300.0}},
    "row-noise": {"": {"sigma_dn": 1.0, "column_sigma_dn": 1.0}},
    "saturation": {"": {"level_dn": 150.0}},
    "sharpening": {"": {"amount": 0.5}},
    "tone-curve": {"": {"gamma": 0.45}},
    "veiling-glare": {"": {"share": 0.05}, "Nearby": {"share": 0.05, "spread": 0.2}},
    "vignetting": {"": {"k1": -0.4}},
    "white-balance": {"": {"red": 1.5}},
}
"""Settings that switch an effect on, by what their suite is called behind the effect's name."""


class InColour(EffectConformance):
    """On tinted images, as mixing the channels leaves greys as they are."""

    def sample(self):
        return super().sample() * np.array([1.0, 0.7, 0.4], np.float32)

    def image(self):
        grey = super().image()
        tinted = tuple((image * np.array([1.0, 0.7, 0.4])).astype(image.dtype) for image in grey.images)
        return replace(grey, images=tinted)


class WithNoise(EffectConformance):
    """On noisy images, as there is no noise to take away from others."""

    def sample(self):
        samples = super().sample()
        return samples + 3 * np.random.default_rng(2).standard_normal(samples.shape, np.float32)

    def image(self):
        frames = super().image()
        rng = np.random.default_rng(2)
        noisy = [np.clip(np.rint(rng.normal(i, 3.0)), 0, 255).astype(np.uint8) for i in frames.images]
        return replace(frames, images=tuple(noisy))


class InSteps(EffectConformance):
    begins_at_once = True


SUITES = {"colour-matrix": InColour, "denoise": WithNoise, "quantisation": InSteps}


def suites_of(component: Component) -> dict[str, type[EffectConformance]]:
    """The suites of an effect: pytest collects them by their names."""
    suite, effect = SUITES.get(component.name, EffectConformance), component.load()
    return {
        (name := f"Test{effect.__name__}{of}"): type(name, (suite,), {"component": effect, "config": config})
        for of, config in SETTINGS[component.name].items()
    }


for each in tacos_components():
    if each.kind == "effect":  # one without settings above is a KeyError
        globals().update(suites_of(each))
