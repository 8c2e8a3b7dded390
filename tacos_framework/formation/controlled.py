"""Images under exposure control: frame by frame, each taken with what the controller made of those before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tacos_framework.contracts import ControllerBase, optional
from tacos_framework.errors import ContractBroken
from tacos_framework.formation.draws import EpisodeDraws
from tacos_framework.formation.placed import PlacedControl
from tacos_framework.formation.views import joined
from tacos_framework.plugins.guarded import calling
from tacos_framework.values import Capture, Exposure, FrameBatch, ImageContext

Expose = Callable[[Capture, Exposure, EpisodeDraws], FrameBatch]
"""The frame of one camera, from its light, under an exposure."""


@dataclass
class _CameraState:
    """State of the control of a camera: the walk, the exposure of its next frame, what is remembered."""

    walk: int
    exposure: Exposure
    memory: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class ExposureLoop:
    """The loop from a frame to the exposure of the next."""

    control: PlacedControl
    start: Exposure
    """The exposure that every walk begins with."""
    expose: Expose
    """Image formation of one frame of one camera."""

    def frames(self, capture: Capture, sensor: str, draws: EpisodeDraws) -> FrameBatch:
        """The frames of a batch, which may begin anywhere in the episode.

        `sensor`: name of the sensor's node: each has cameras of its own to control. `draws`: generators of
        the episode, and what the controller keeps.
        """
        taken = [
            [self._frame(capture, number, i, sensor, draws) for i in range(len(capture.episode))]
            for number in range(len(capture.views))
        ]
        views = [
            joined([frame.capture.views[0] for frame, _ in frames], view)
            for frames, view in zip(taken, capture.views, strict=True)
        ]
        images = [np.concatenate([frame.images[0] for frame, _ in frames]) for frames in taken]
        first = taken[0][0][0]
        return FrameBatch(
            capture=replace(capture, views=tuple(views), pending=()),
            images=tuple(images),
            black_level_dn=first.black_level_dn,
            white_level_dn=first.white_level_dn,
            coded=first.coded,
            exposures=tuple(tuple(exposure for _, exposure in frames) for frames in taken),
            dn_per_electron=tuple(
                tuple(frame.dn_per_electron[0][0] for frame, _ in frames) for frames in taken
            ),
        )

    def _frame(
        self, capture: Capture, number: int, index: int, sensor: str, draws: EpisodeDraws
    ) -> tuple[FrameBatch, Exposure]:
        """One frame of one camera, and its exposure; sets that of the next."""
        view = capture.views[number]
        one = replace(capture, episode=capture.episode[index : index + 1], views=(view.frame(index),))
        kept = draws.memory("control", sensor, view.camera.name)
        walk = int(capture.episode.walk[index])
        state: _CameraState | None = kept.get("state")
        if state is None or state.walk != walk:
            state = kept["state"] = _CameraState(walk, self.start)
            self._warm_up(one, state, draws)
        exposure = state.exposure
        frame = self.expose(one, exposure, draws)
        state.exposure = self._next(frame, state)
        return frame, exposure

    def _warm_up(self, one: Capture, state: _CameraState, draws: EpisodeDraws) -> None:
        """Let the camera look at the first view of a walk for a while, with draws of its own."""
        for count in range(optional(self.control.controller, ControllerBase, "warm_up_frames")):
            before = EpisodeDraws(draws.seed, (*draws.names, "warm-up", count))
            state.exposure = self._next(self.expose(one, state.exposure, before), state)

    def _next(self, frame: FrameBatch, state: _CameraState) -> Exposure:
        context = ImageContext(
            exposure_s=state.exposure.time_s,
            gain_db=state.exposure.gain_db,
            f_number=state.exposure.f_number,
            black_level_dn=frame.black_level_dn,
            white_level_dn=frame.white_level_dn,
            memory=state.memory,
        )
        control = self.control
        with calling(control.use, doing="adjust"):
            chosen = control.controller.adjust(frame.images[0][0], exposure=state.exposure, context=context)
            if not isinstance(chosen, Exposure):
                raise ContractBroken(f"{control.use} gives a {type(chosen).__name__}, not an Exposure")
            return chosen
