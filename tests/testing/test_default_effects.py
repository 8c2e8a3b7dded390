"""The default effects pass the suite that third parties are given."""

# ruff: noqa: RUF012 - settings stand as plain class attributes, as plugin authors will write them

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tacos_framework.testing import EffectConformance
from tacos_plugins.effects.auto_exposure import AutoExposure
from tacos_plugins.effects.auto_white_balance import AutoWhiteBalance
from tacos_plugins.effects.black_level import BlackLevel
from tacos_plugins.effects.colour_matrix import ColourMatrix
from tacos_plugins.effects.conversion_gain_error import ConversionGainError
from tacos_plugins.effects.conversion_gain_mode import ConversionGainMode
from tacos_plugins.effects.crosstalk import Crosstalk
from tacos_plugins.effects.dark_current import DarkCurrent
from tacos_plugins.effects.defect_lines import DefectLines
from tacos_plugins.effects.defocus import Defocus
from tacos_plugins.effects.demosaic import Demosaic
from tacos_plugins.effects.denoise import Denoise
from tacos_plugins.effects.dsnu import Dsnu
from tacos_plugins.effects.exposure_error import ExposureError
from tacos_plugins.effects.flicker import Flicker
from tacos_plugins.effects.focal_length_error import FocalLengthError
from tacos_plugins.effects.illumination_gradient import IlluminationGradient
from tacos_plugins.effects.jpeg import Jpeg
from tacos_plugins.effects.lateral_chromatic_aberration import LateralChromaticAberration
from tacos_plugins.effects.lens import Lens
from tacos_plugins.effects.lens_blur import LensBlur
from tacos_plugins.effects.lens_distortion import LensDistortion
from tacos_plugins.effects.lens_shading_correction import LensShadingCorrection
from tacos_plugins.effects.motion import Motion
from tacos_plugins.effects.motion_blur import MotionBlur
from tacos_plugins.effects.nonlinearity import Nonlinearity
from tacos_plugins.effects.pose_error import PoseError
from tacos_plugins.effects.prnu import Prnu
from tacos_plugins.effects.quantisation import Quantisation
from tacos_plugins.effects.read_noise import ReadNoise
from tacos_plugins.effects.rolling_shutter import RollingShutter
from tacos_plugins.effects.row_noise import RowNoise
from tacos_plugins.effects.saturation import Saturation
from tacos_plugins.effects.sharpening import Sharpening
from tacos_plugins.effects.tone_curve import ToneCurve
from tacos_plugins.effects.veiling_glare import VeilingGlare
from tacos_plugins.effects.vignetting import Vignetting
from tacos_plugins.effects.white_balance import WhiteBalance


class TestVignetting(EffectConformance):
    component = Vignetting
    config = {"k1": -0.4}


class TestExposureError(EffectConformance):
    component = ExposureError
    config = {"scale": 1.3}


class TestIlluminationGradient(EffectConformance):
    component = IlluminationGradient
    config = {"gx": 0.2, "gy": -0.1}


class TestFocalLengthError(EffectConformance):
    component = FocalLengthError
    config = {"scale": 1.05, "dx_px": 1.5, "dy_px": -0.5}


class TestLensDistortion(EffectConformance):
    component = LensDistortion
    config = {"k1": -0.1, "k2": 0.02, "p1": 0.003}


class TestLensDistortionFisheye(EffectConformance):
    component = LensDistortion
    config = {"model": "fisheye", "k1": 0.05}


class TestLateralChromaticAberration(EffectConformance):
    component = LateralChromaticAberration
    config = {"red": 0.004, "blue": -0.003, "red_r2": 0.002}


class TestDefocus(EffectConformance):
    component = Defocus
    config = {"radius_px": 2.5}


class TestDefocusOnTheSensor(EffectConformance):
    component = Defocus
    config = {"radius_um": 7.5}


class TestDefocusByDepth(EffectConformance):
    component = Defocus
    config = {"focus_m": 0.5}


class TestLensBlur(EffectConformance):
    component = LensBlur
    config = {"sigma_px": 1.2, "growth": 0.8}


class TestLensBlurByDiffraction(EffectConformance):
    component = LensBlur
    config = {"wavelength_nm": 2000.0}


class TestLens(EffectConformance):
    component = Lens
    config = {"wavelength_nm": 550.0, "focus_m": 0.3, "out_of_focus": 1.0, "fall_off": 1.0}


class TestMotionBlur(EffectConformance):
    component = MotionBlur
    config = {"length_px": 5.0, "angle_deg": 30.0}


class TestMotion(EffectConformance):
    component = Motion
    config = {"amount": 2.0, "shutter": "rolling", "row_time_us": 300.0}


class TestRollingShutter(EffectConformance):
    component = RollingShutter
    config = {"row_time_us": 300.0}


class TestFlicker(EffectConformance):
    component = Flicker
    config = {"depth": 0.3, "period_rows": 20.0}


class TestVeilingGlare(EffectConformance):
    component = VeilingGlare
    config = {"share": 0.05}


class TestVeilingGlareNearby(EffectConformance):
    component = VeilingGlare
    config = {"share": 0.05, "spread": 0.2}


class TestPoseError(EffectConformance):
    component = PoseError
    config = {"rx": 1.0, "ry": -0.5, "rz": 2.0}


class TestPoseErrorWithAShift(EffectConformance):
    component = PoseError
    config = {"tx": 100.0, "tz": 50.0}


class TestAutoExposure(EffectConformance):
    component = AutoExposure
    config = {"target_mlx_s": 15.0, "lag_frames": 2.0}


class TestAutoExposureAgainstTheFirstFrame(EffectConformance):
    component = AutoExposure
    config = {"strength": 0.5, "first": 1.5, "lag_frames": 2.0}


class TestAutoWhiteBalance(EffectConformance):
    component = AutoWhiteBalance
    config = {"red_first": 1.3, "blue_first": 0.8, "lag_frames": 2.0}


class TestBlackLevel(EffectConformance):
    component = BlackLevel
    config = {"offset_dn": 3.0}


class TestColourMatrix(EffectConformance):
    component = ColourMatrix
    config = {"matrix": ((1.6, -0.4, -0.2), (-0.3, 1.5, -0.2), (0.0, -0.6, 1.6))}

    def sample(self):
        return super().sample() * np.array([1.0, 0.7, 0.4], np.float32)

    def image(self):
        grey = super().image()
        tinted = tuple((image * np.array([1.0, 0.7, 0.4])).astype(image.dtype) for image in grey.images)
        return replace(grey, images=tinted)


class TestConversionGainError(EffectConformance):
    component = ConversionGainError
    config = {"scale": 1.3}


class TestConversionGainMode(EffectConformance):
    component = ConversionGainMode
    config = {"noise_scale": 0.5}


class TestCrosstalk(EffectConformance):
    component = Crosstalk
    config = {"share": 0.02}


class TestDarkCurrent(EffectConformance):
    component = DarkCurrent
    config = {"rate_dn_s": 100.0, "hot_share": 0.01}


class TestDemosaic(EffectConformance):
    component = Demosaic
    config = {"method": "bilinear"}


class TestDenoise(EffectConformance):
    component = Denoise
    config = {"strength": 1.0}

    def sample(self):
        """An image with noise, as there is none to take away from others."""
        samples = super().sample()
        return samples + 3 * np.random.default_rng(2).standard_normal(samples.shape, np.float32)

    def image(self):
        frames = super().image()
        rng = np.random.default_rng(2)
        noisy = [np.clip(np.rint(rng.normal(i, 3.0)), 0, 255).astype(np.uint8) for i in frames.images]
        return replace(frames, images=tuple(noisy))


class TestDefectLines(EffectConformance):
    component = DefectLines
    config = {"column_share": 0.1, "row_share": 0.05, "offset_dn": 8.0}


class TestDsnu(EffectConformance):
    component = Dsnu
    config = {"sigma_dn": 1.0, "column_sigma_dn": 1.0}


class TestJpeg(EffectConformance):
    component = Jpeg
    config = {"quality": 70}


class TestLensShadingCorrection(EffectConformance):
    component = LensShadingCorrection
    config = {"k1": 1.0}


class TestNonlinearity(EffectConformance):
    component = Nonlinearity
    config = {"a2": -0.1}


class TestPrnu(EffectConformance):
    component = Prnu
    config = {"sigma": 0.02}


class TestQuantisation(EffectConformance):
    component = Quantisation
    config = {"step_dn": 4.0}
    begins_at_once = True


class TestReadNoise(EffectConformance):
    component = ReadNoise
    config = {"sigma_dn": 1.0, "tail": 0.2}


class TestReadNoiseInElectrons(EffectConformance):
    component = ReadNoise
    config = {"sigma_e": 12.0}


class TestRowNoise(EffectConformance):
    component = RowNoise
    config = {"sigma_dn": 1.0, "column_sigma_dn": 1.0}


class TestSaturation(EffectConformance):
    component = Saturation
    config = {"level_dn": 150.0}


class TestSharpening(EffectConformance):
    component = Sharpening
    config = {"amount": 0.5}


class TestToneCurve(EffectConformance):
    component = ToneCurve
    config = {"gamma": 0.45}


class TestWhiteBalance(EffectConformance):
    component = WhiteBalance
    config = {"red": 1.5}
