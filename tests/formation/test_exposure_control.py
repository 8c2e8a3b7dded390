"""Images under exposure control: causal, one code path with a fixed exposure, whatever the batches."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.errors import ContractBroken
from tacos_framework.formation import EpisodeDraws, ImageFormation, PlacedControl, PlacedEffect, PlacedSensor
from tacos_framework.settings import Settings, physical, setting
from tacos_framework.testing.samples import part_of, sample_capture, sample_exposure, sample_rig
from tacos_framework.values import Exposure
from tacos_plugins.controls.mean_level import MeanLevel
from tacos_plugins.effects.motion_blur import MotionBlur
from tacos_plugins.effects.tone_curve import ToneCurve
from tacos_plugins.sensors.affine_noise import AffineNoise

SENSOR = PlacedSensor("sensor.affine-noise", "frames", AffineNoise(AffineNoise.Config()))
BLUR = PlacedEffect("effect.motion-blur", "blur", MotionBlur, MotionBlur.Config(speed_deg_s=60))
CURVE = PlacedEffect("effect.tone-curve", "curve", ToneCurve, ToneCurve.Config(gamma=2.2))


def draws() -> EpisodeDraws:
    return EpisodeDraws(7, ("test", 0))


@dataclass
class Recording:
    """Halves the time after each frame, and keeps what it was shown."""

    warm_up_frames: int = 0
    shown: list[Any] = field(default_factory=list)

    def adjust(self, frame_dn, *, exposure, context):
        self.shown.append(frame_dn.copy())
        context.memory["calls"] = context.memory.get("calls", 0) + 1
        return replace(exposure, time_s=0.030 / 2 ** context.memory["calls"])


class Amplifying:
    """Adds gain and takes away time from frame to frame."""

    def adjust(self, frame_dn, *, exposure, context):
        return replace(exposure, gain_db=exposure.gain_db + 4, time_s=exposure.time_s / 1.5)


class Adding:
    """Adds to files: a number of DN or of electrons, and as many DN as the camera turns pixels."""

    class Config(Settings):
        by: float = setting(0.0, help="How much.", unit="DN")
        by_e: float | None = physical("by", help="The same in electrons.", unit="e-")
        by_px: float = setting(0.0, help="How far.", unit="px")
        by_deg_s: float | None = physical("by_px", help="The same as speed.", unit="deg/s")

    stage: ClassVar[Any] = "isp"
    neutral: ClassVar[Any] = {"by": 0.0, "by_px": 0.0}

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(self, samples, *, geometry, context, rng):
        return samples + np.float32(self.config.by + self.config.by_px)


def formed(control: Any, capture=None, effects=(), given=None):
    formation = ImageFormation(sample_exposure(), effects, PlacedControl("control.test", control))
    given = given or draws()
    capture = sample_capture(frames=4) if capture is None else capture
    return formation.expose(formation.light(capture, given), SENSOR, given)


def test_a_frame_is_taken_with_what_the_frames_before_it_led_to():
    control = Recording()
    frames = formed(control)
    assert [exposure.time_s for exposure in frames.exposures[0]] == [0.030, 0.015, 0.0075, 0.00375]
    for shown, image in zip(control.shown, frames.images[0], strict=True):
        np.testing.assert_array_equal(shown, image)


@pytest.mark.parametrize("effects", [(), (BLUR, CURVE)])
def test_each_frame_is_that_of_the_same_exposure_held_fixed(effects):
    """There is no second image formation: control only chooses with which exposure it is called."""
    frames = formed(Recording(), effects=effects)
    for i, exposure in enumerate(frames.exposures[0]):
        fixed, own = ImageFormation(exposure, effects), draws()
        alone = fixed.expose(fixed.light(part_of(sample_capture(frames=4), i, i + 1), own), SENSOR, own)
        np.testing.assert_array_equal(frames.images[0][i], alone.images[0][0])
        lit, expected = (each.capture.views[0].luminance_cd_m2 for each in (frames, alone))
        np.testing.assert_array_equal(lit[i], expected[0])


def test_an_effect_on_light_in_the_graph_waits_for_the_exposure():
    formation = ImageFormation(sample_exposure(), (), PlacedControl("control.test", Recording()))
    own, capture = draws(), sample_capture(frames=4)
    waiting = formation.with_effect(formation.light(capture, own), BLUR, own)
    assert waiting.pending == (BLUR,)
    in_graph = formation.expose(waiting, SENSOR, own)
    np.testing.assert_array_equal(in_graph.images[0], formed(Recording(), effects=[BLUR]).images[0])


@pytest.mark.parametrize("given", ["by_e", "by_deg_s"])
def test_an_effect_on_files_in_the_graph_is_in_the_units_of_each_frame(given: str):
    """Gain and time differ from frame to frame, and with them what an electron or a turn comes to."""
    effect = PlacedEffect("effect.adding", "adding", Adding, Adding.Config(**{given: 300.0}))
    formation = ImageFormation(sample_exposure(), (), PlacedControl("control.test", Amplifying()))
    capture, own = sample_capture(frames=3), draws()
    found = formation.with_effect(formation.expose(capture, SENSOR, own), effect, own)
    for i, exposure in enumerate(found.exposures[0]):
        fixed, own = ImageFormation(exposure, [effect]), draws()
        alone = fixed.expose(part_of(capture, i, i + 1), SENSOR, own)
        np.testing.assert_array_equal(found.images[0][i], alone.images[0][0])


def test_batches_do_not_matter():
    whole, capture, own = formed(Recording()), sample_capture(frames=4), draws()
    control = Recording()
    halves = [formed(control, part_of(capture, *run), given=own) for run in ((0, 1), (1, 4))]
    np.testing.assert_array_equal(np.concatenate([half.images[0] for half in halves]), whole.images[0])


def test_a_new_walk_begins_anew():
    capture = sample_capture(frames=4)
    walks = replace(capture.episode, walk=np.array([0, 0, 1, 1], np.int32))
    frames = formed(Recording(), replace(capture, episode=walks))
    assert [exposure.time_s for exposure in frames.exposures[0]] == [0.030, 0.015, 0.030, 0.015]


def test_each_camera_is_controlled_by_itself():
    control = MeanLevel(MeanLevel.Config(lag_frames=0, warm_up_frames=0))
    capture = sample_capture(sample_rig("left", "right"), frames=3)
    left, right = capture.views
    darker = replace(right, luminance_cd_m2=right.luminance_cd_m2 / 4)
    frames = formed(control, replace(capture, views=(left, darker)))
    left, right = (each[-1] for each in frames.exposures)
    assert right.time_s * right.gain > 2 * left.time_s * left.gain


def test_a_camera_that_has_warmed_up_begins_settled():
    cold, warm = (
        formed(MeanLevel(MeanLevel.Config(lag_frames=3, warm_up_frames=count))).images[0] for count in (0, 40)
    )
    assert warm[0].mean() == pytest.approx(0.2 * 255, rel=0.1)
    assert abs(cold[0].mean() - 0.2 * 255) > abs(warm[0].mean() - 0.2 * 255)


def test_what_is_no_exposure_is_refused():
    class Wrong:
        def adjust(self, frame_dn, *, exposure, context):
            return exposure.time_s

    with pytest.raises(ContractBroken, match=r"control\.test gives a float, not an Exposure"):
        formed(Wrong())


def test_a_fixed_exposure_names_none():
    formation, own = ImageFormation(sample_exposure()), draws()
    assert formation.expose(sample_capture(), SENSOR, own).exposures == ()
    assert isinstance(formed(Recording()).exposures[0][0], Exposure)
