"""Conformance suite of exposure controls."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.formation.arrays import digitise
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.samples import sample_capture, sample_exposure
from tacos_framework.values import Exposure, ImageContext

FRAMES = 60
"""Frames of a still scene after which a camera must have settled."""
SETTLED = 0.2
"""Largest difference of exposures of such a frame and the next, in stops."""


class ControlConformance(ComponentConformance):
    """The suite for exposure controls, with a textured card before a linear camera of 8 bits."""

    kind: ClassVar[str] = "control"

    def exposures(self, control: Any, luminance_cd_m2: float, frames: int = FRAMES) -> Iterator[Exposure]:
        """Exposures after each frame of a still scene."""
        light = sample_capture(frames=1).views[0].luminance_cd_m2[0]
        light = light / light.mean() * luminance_cd_m2
        exposure, memory = sample_exposure(), dict[str, Any]()
        for _ in range(frames):
            frame = digitise(light * exposure.time_s * exposure.gain * 400, 255)
            exposure = control.adjust(frame, exposure=exposure, context=self.context(exposure, memory))
            yield exposure

    def context(self, exposure: Exposure, memory: dict[str, Any]) -> ImageContext:
        return ImageContext(exposure.time_s, exposure.gain_db, exposure.f_number, memory=memory)

    def settled(self, luminance_cd_m2: float) -> Exposure:
        return list(self.exposures(self.make(), luminance_cd_m2))[-1]

    def test_its_warm_up_is_a_number_of_frames(self) -> None:
        assert int(getattr(self.make(), "warm_up_frames", 0)) >= 0

    def test_less_light_is_exposed_no_less(self) -> None:
        bright, dark = (self.settled(light) for light in (20.0, 0.5))
        assert dark.time_s * dark.gain >= bright.time_s * bright.gain

    def test_it_leaves_the_aperture_alone(self) -> None:
        assert self.settled(3.0).f_number == sample_exposure().f_number

    @pytest.mark.parametrize("luminance_cd_m2", [0.5, 3.0, 20.0])
    def test_it_settles(self, luminance_cd_m2: float) -> None:
        *_, before, last = self.exposures(self.make(), luminance_cd_m2)
        stops = np.log2(last.time_s * last.gain / (before.time_s * before.gain))
        assert abs(stops) <= SETTLED, f"after {FRAMES} frames it still changes by {stops:+.2f} stops a frame"

    @pytest.mark.parametrize("level_dn", [0, 255])
    def test_it_takes_frames_that_are_black_or_full(self, level_dn: int) -> None:
        for channels in (1, 3):
            frame = np.full((48, 64, channels), level_dn, np.uint8)
            chosen = self.make().adjust(
                frame, exposure=sample_exposure(), context=self.context(sample_exposure(), {})
            )
            assert isinstance(chosen, Exposure)

    def test_it_keeps_nothing_of_its_own_between_calls(self) -> None:
        """Memory from frame to frame belongs into `context.memory`."""
        used = self.make()
        list(self.exposures(used, 20.0, frames=5))
        assert [*self.exposures(used, 1.0, 5)] == [*self.exposures(self.make(), 1.0, 5)]

    def test_it_leaves_its_frame_as_it_was(self) -> None:
        frame = np.full((48, 64, 3), 90, np.uint8)
        frame.flags.writeable = False
        self.make().adjust(frame, exposure=sample_exposure(), context=self.context(sample_exposure(), {}))
