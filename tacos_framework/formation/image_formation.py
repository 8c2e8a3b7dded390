"""Image formation of captures and frames, as a study calls it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts import FILE_STAGES, LIGHT_STAGES, EffectBase, optional
from tacos_framework.errors import Fault, UserError
from tacos_framework.formation.arrays import SensorAt, digital, file_type, form_files
from tacos_framework.formation.chain import EffectChain
from tacos_framework.formation.controlled import ExposureLoop
from tacos_framework.formation.draws import EpisodeDraws
from tacos_framework.formation.placed import PlacedControl, PlacedEffect, PlacedSensor
from tacos_framework.formation.views import light_context, with_light_effects
from tacos_framework.plugins.guarded import blameless
from tacos_framework.values import (
    Capture,
    ContextMissing,
    Exposure,
    FrameBatch,
    ImageContext,
    ImageGeometry,
    View,
)


class ImageFormation:
    """Image formation under one exposure, with the effects that hold for all images.

    - `effects`: the effects of the recipe, in any order.
    - `control`: who sets the exposure from frame to frame, beginning with the scenario's; None where it is
      fixed. Then light waits for the sensor, as its exposure is not known before, and effects on it with it.
    """

    def __init__(
        self, exposure: Exposure, effects: Sequence[PlacedEffect] = (), control: PlacedControl | None = None
    ):
        self.exposure = exposure
        self.effects = tuple(effects)
        self.control = control

    def light(self, capture: Capture, draws: EpisodeDraws) -> Capture:
        """The capture of a renderer with the effects on light."""
        return capture if self.control else self._light(capture, self.effects, draws)

    def with_effect(
        self, image: Capture | FrameBatch, effect: PlacedEffect, draws: EpisodeDraws
    ) -> Capture | FrameBatch:
        """An image that passes a node of the graph that is an effect.

        Light and files change at once; effects of the stages pixel and readout wait for the sensor.
        """
        stage = effect.cls.stage
        if isinstance(image, FrameBatch):
            if stage not in FILE_STAGES:
                raise TypeError(f"{effect.use} of the stage {stage} acts before there are frames")
            return self._files(image, effect, draws)
        if stage in LIGHT_STAGES and not self.control:
            return self._light(image, [effect], draws)
        return replace(image, pending=(*image.pending, effect))

    def expose(self, capture: Capture, sensor: PlacedSensor, draws: EpisodeDraws) -> FrameBatch:
        """The frames of a batch, with the effects inside the sensor and on its files.

        Returns: uint8 up to a white level of 255, else uint16 [DN].

        Raises `UserError` when the files of one camera have another range than those of the first.
        """
        sensor = sensor.behind([view.camera for view in capture.views])
        black_level_dn, white_level_dn = sensor.range_dn([view.camera.name for view in capture.views])
        if self.control:
            loop = ExposureLoop(self.control, self.exposure, partial(self._at, capture.pending, sensor))
            return loop.frames(replace(capture, pending=()), sensor.name, draws)
        effects = (*self.effects, *capture.pending)
        places = [self._sensor_at(sensor, view) for view in capture.views]
        chains = [EffectChain.of(effects, ImageGeometry.of_camera(at.camera), at.context) for at in places]
        images = [
            self._exposed(view, capture, at, chain, draws)
            for view, at, chain in zip(capture.views, places, chains, strict=True)
        ]
        return FrameBatch(
            capture=replace(capture, pending=()),
            images=tuple(images),
            black_level_dn=black_level_dn,
            white_level_dn=white_level_dn,
            dn_per_electron=tuple((at.context.dn_per_electron,) * len(capture.episode) for at in places),
            coded=any(chain.codes for chain in chains),
        )

    def _at(
        self,
        pending: Sequence[PlacedEffect],
        sensor: PlacedSensor,
        capture: Capture,
        exposure: Exposure,
        draws: EpisodeDraws,
    ) -> FrameBatch:
        """Frames of light that has waited, under one exposure."""
        fixed = ImageFormation(exposure, self.effects)
        capture = fixed.light(capture, draws)
        for effect in pending:
            capture = fixed.with_effect(capture, effect, draws)  # type: ignore[assignment]
        return fixed.expose(capture, sensor, draws)

    def _sensor_at(self, sensor: PlacedSensor, view: View) -> SensorAt:
        """The sensor behind the camera of a view."""
        camera = view.camera
        return SensorAt(sensor.use, sensor.name, sensor.at(camera.name), camera, self.exposure)

    def _exposed(
        self, view: View, capture: Capture, at: SensorAt, chain: EffectChain, draws: EpisodeDraws
    ) -> NDArray[np.unsignedinteger]:
        """The files of one camera, frame by frame."""
        geometry = ImageGeometry.of_camera(view.camera)
        files = []
        for i in range(len(capture.episode)):
            try:
                light = view.luminance_cd_m2[i : i + 1]
                expected = at.expect(light)
                noise = view.noise_cd2_m4
                carried = None if noise is None else at.carried_dn2(light, noise[i : i + 1], expected)
                made = form_files(
                    expected,
                    chain.for_channels(expected.shape[-1]),
                    at,
                    geometry=geometry,
                    context=replace(at.context, depth_m=view.depth_m[i]),
                    draws=draws,
                    frame=capture.episode.first_frame + i,
                    carried_dn2=carried,
                )
            except ContextMissing as missing:
                raise _unknown(view.camera.name, missing) from missing
            files.append(made.astype(file_type(at.context.white_level_dn)))
        return files[0] if len(files) == 1 else np.concatenate(files)

    def _light(self, capture: Capture, effects: Sequence[PlacedEffect], draws: EpisodeDraws) -> Capture:
        chosen = [effect for effect in effects if effect.cls.stage in LIGHT_STAGES]
        if not chosen:
            return capture
        views = []
        for view in capture.views:
            context = light_context(view, capture.episode, self.exposure)
            acting = EffectChain.of(chosen, ImageGeometry.of_camera(view.camera), context).light
            try:
                views.append(with_light_effects(view, capture.episode, acting, self.exposure, draws))
            except ContextMissing as missing:
                raise _unknown(view.camera.name, missing) from missing
        same = all(after is before for after, before in zip(views, capture.views, strict=True))
        return capture if same else replace(capture, views=tuple(views))

    def _files(self, frames: FrameBatch, effect: PlacedEffect, draws: EpisodeDraws) -> FrameBatch:
        """Frames with one effect; the batch itself where it is off."""
        images = [self._processed(frames, number, effect, draws) for number in range(len(frames.images))]
        same = all(after is before for after, before in zip(images, frames.images, strict=True))
        coded = frames.coded or optional(effect.cls(effect.config), EffectBase, "codes")
        return frames if same else replace(frames, images=tuple(images), coded=coded)

    def _processed(
        self, frames: FrameBatch, number: int, effect: PlacedEffect, draws: EpisodeDraws
    ) -> NDArray[np.unsignedinteger]:
        """The files of one camera with an effect, each in the units of its own exposure."""
        image, view = frames.images[number], frames.capture.views[number]
        geometry = ImageGeometry.of_camera(view.camera)
        chains: dict[tuple[float, float, float | None], EffectChain] = {}
        changed: dict[int, NDArray[Any]] = {}
        for i in range(len(image)):
            context = self._file_context(frames, number, i)
            units = (context.exposure_s, context.gain_db, context.dn_per_electron)
            if units not in chains:
                chains[units] = EffectChain.of([effect], geometry, context)
            before = image[i : i + 1].astype(np.float32)
            after = before
            try:
                for acting in chains[units].for_channels(image.shape[-1]).files:
                    after = acting.on(
                        after,
                        geometry=geometry,
                        context=context,
                        draws=draws,
                        frame=frames.episode.first_frame + i,
                    )
            except ContextMissing as missing:
                raise _unknown(view.camera.name, missing) from missing
            if after is not before:
                changed[i] = digital(after, frames.white_level_dn).astype(image.dtype)
        if not changed:
            return image
        return np.concatenate([changed.get(i, image[i : i + 1]) for i in range(len(image))])

    def _file_context(self, frames: FrameBatch, number: int, index: int) -> ImageContext:
        """Circumstances of one file of a camera."""
        taken = frames.exposures[number][index] if frames.exposures else self.exposure
        return ImageContext(
            exposure_s=taken.time_s,
            gain_db=taken.gain_db,
            f_number=taken.f_number,
            black_level_dn=frames.black_level_dn,
            white_level_dn=frames.white_level_dn,
            depth_m=frames.capture.views[number].depth_m[index],
            dn_per_electron=frames.dn_per_electron[number][index] if frames.dn_per_electron else None,
        )


def _unknown(camera: str, missing: ContextMissing) -> UserError:
    """The error of an effect that needs what a simulation does not know."""
    remedy = "Use a sensor that gives it, or take the effect out of the recipe."
    return blameless(UserError(Fault(f"camera {camera!r}", str(missing), "", remedy)))
