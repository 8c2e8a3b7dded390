"""What every sensor must do."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from tacos_framework.testing.call import supplied
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.samples import NoEffects, part_of, sample_capture, sample_exposure, sample_rig
from tacos_framework.values import Capture, FrameBatch, Signal


class SensorConformance(ComponentConformance):
    """The suite for sensors."""

    kind: ClassVar[str] = "sensor"

    def expose(
        self,
        capture: Capture,
        *,
        seed: int = 1,
        effects: object = None,
        time_s: float = 0.030,
        rng: np.random.Generator | None = None,
    ) -> FrameBatch:
        """Frames of a capture by a new instance of the sensor."""
        sensor = self.make()
        keywords = supplied(
            sensor.expose,
            rig=sample_rig(*(view.camera.name for view in capture.views)),
            exposure=sample_exposure(time_s=time_s),
            rng=rng or np.random.default_rng(seed),
            effects=effects or NoEffects(),
        )
        frames = sensor.expose(capture, **keywords)
        assert isinstance(frames, FrameBatch)
        return frames

    def test_it_gives_an_image_per_camera_and_frame(self) -> None:
        capture = sample_capture(sample_rig("left", "right"), frames=3)
        frames = self.expose(capture)
        assert frames.capture.episode is capture.episode
        assert len(frames.images) == 2
        for image in frames.images:
            assert image.shape[:3] == (3, 48, 64)
            assert image.shape[3] in (1, 3)

    def test_its_levels_bound_its_images(self) -> None:
        frames = self.expose(sample_capture(luminance_cd_m2=1e6))
        assert 0 <= frames.black_level_dn < frames.white_level_dn
        assert frames.white_level_dn <= np.iinfo(frames.images[0].dtype).max
        assert frames.images[0].max() <= frames.white_level_dn

    def test_equal_generators_give_equal_images(self) -> None:
        capture = sample_capture()
        assert fingerprint(self.expose(capture).images) == fingerprint(self.expose(capture).images)

    def test_it_leaves_the_capture_as_it_was(self) -> None:
        capture = sample_capture()
        before = fingerprint(capture)
        self.expose(capture)
        assert fingerprint(capture) == before

    def test_batches_may_be_cut_anywhere(self) -> None:
        """One generator runs through the batches of an episode, so noise must be drawn frame by frame."""
        capture = sample_capture(sample_rig("left", "right"), frames=3)
        whole = self.expose(capture).images
        rng = np.random.default_rng(1)
        parts = [self.expose(part_of(capture, *cut), rng=rng).images for cut in ((0, 1), (1, 3))]
        for camera, image in enumerate(whole):
            joined = np.concatenate([part[camera] for part in parts])
            np.testing.assert_array_equal(joined, image)

    def test_more_light_gives_brighter_images(self) -> None:
        capture = sample_capture(luminance_cd_m2=0.5)
        short, long = (self.expose(capture, time_s=time_s).images[0].mean() for time_s in (0.010, 0.040))
        assert short < long, f"mean {short} DN at 10 ms, {long} DN at 40 ms"

    def test_it_calls_the_effects_of_each_view_in_order(self) -> None:
        recorder = _Recorder()
        self.expose(sample_capture(sample_rig("left", "right")), effects=recorder)
        for name in ("left", "right"):
            assert [stage for stage, camera in recorder.calls if camera == name] == ["pixel", "readout"]

    def test_what_effects_return_reaches_the_image(self) -> None:
        assert self.expose(sample_capture(), effects=_Blank()).images[0].max() == 0


@dataclass
class _Recorder:
    """Notes which effects were called for which camera."""

    calls: list[tuple[str, str]] = field(default_factory=list)

    def pixel(self, signal: Signal) -> Signal:
        self.calls.append(("pixel", signal.view.camera.name))
        return signal

    def readout(self, signal: Signal) -> Signal:
        self.calls.append(("readout", signal.view.camera.name))
        return signal


class _Blank(NoEffects):
    """A readout that delivers zeros."""

    def readout(self, signal: Signal) -> Signal:
        zeros = np.zeros_like(signal.samples_dn)
        return Signal(signal.view, zeros, signal.black_level_dn, signal.white_level_dn)
