"""The effects of one image, each at its place and in the units of that image."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any

from numpy.typing import NDArray

from tacos_framework.camera.motion import Places
from tacos_framework.camera.resampling import resample
from tacos_framework.contracts import (
    FILE_STAGES,
    LIGHT_STAGES,
    EffectBase,
    acts_after_noise,
    formation_order,
    moves_pixels,
    optional,
)
from tacos_framework.formation.checked import checked_samples
from tacos_framework.formation.draws import EpisodeDraws
from tacos_framework.formation.image_units import in_image_units
from tacos_framework.formation.placed import PlacedEffect
from tacos_framework.plugins.guarded import calling
from tacos_framework.values import ImageContext, ImageGeometry


@dataclass(frozen=True)
class ActingEffect:
    """An effect in the units of the image it acts on."""

    use: str
    name: str
    effect: Any

    def on(
        self,
        samples: NDArray[Any],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        draws: EpisodeDraws,
        frame: int,
    ) -> NDArray[Any]:
        """Samples of one frame, (1, H, W, C), with the effect; the very array where it is off."""
        with calling(self.use, doing="on_array"):
            if moves_pixels(type(self.effect)):
                places = self.source(geometry=geometry, context=context, frames=len(samples))
                return samples if places is None else resample(samples, *places)
            changed = self.effect.on_array(
                samples,
                geometry=geometry,
                context=replace(context, memory=draws.memory("effect", self.name, geometry.camera)),
                rng=draws.rng(frame, "effect", self.name, geometry.camera),
            )
            return samples if changed is samples else checked_samples(self.use, changed, samples)

    def source(self, *, geometry: ImageGeometry, context: ImageContext, frames: int) -> Places | None:
        """Places at which pixels look, of an effect that moves pixels; None where it is off [px]."""
        with calling(self.use, doing="source"):
            places: Places | None = self.effect.source(geometry=geometry, context=context, frames=frames)
        return places


@dataclass(frozen=True)
class EffectChain:
    """The effects of one image in the order of image formation."""

    light: tuple[ActingEffect, ...] = ()
    pixel: tuple[ActingEffect, ...] = ()
    readout: tuple[ActingEffect, ...] = ()
    files: tuple[ActingEffect, ...] = ()
    photon_scale: float = 1.0
    dark_scale: float = 1.0

    @property
    def codes(self) -> bool:
        """True if files come out coded for a display."""
        return any(optional(each.effect, EffectBase, "codes") for each in self.files)

    def for_channels(self, count: int) -> EffectChain:
        """The chain of an image of so many channels: what acts on colours alone passes by one of one."""
        if count > 1:
            return self
        kept = (e for e in self.files if not optional(type(e.effect), EffectBase, "of_colours"))
        return replace(self, files=tuple(kept))

    @classmethod
    def of(
        cls, placed: Iterable[PlacedEffect], geometry: ImageGeometry, context: ImageContext
    ) -> EffectChain:
        """The chain of those effects that act on a camera, in the units of its image.

        Raises `CandidateFailed` where settings cannot be had on this camera.
        """
        ordered = sorted(placed, key=lambda each: formation_order(each.cls))
        acting = []
        for each in ordered:
            config = each.config_at(geometry.camera)
            if config is not None:
                effect = each.cls(in_image_units(config, each.use, geometry, context))
                acting.append(ActingEffect(each.use, each.name, effect))
        return cls._of_acting(acting, context)

    @classmethod
    def _of_acting(cls, ordered: Sequence[ActingEffect], context: ImageContext) -> EffectChain:
        """The chain of effects that are in the units of the image already, in order."""

        def stage(each: ActingEffect) -> str:
            return str(type(each.effect).stage)

        light = tuple(each for each in ordered if stage(each) in LIGHT_STAGES)
        files = tuple(each for each in ordered if stage(each) in FILE_STAGES)
        inside = [each for each in ordered if each not in light and each not in files]
        return cls(
            light=light,
            pixel=tuple(each for each in inside if not acts_after_noise(type(each.effect))),
            readout=tuple(each for each in inside if acts_after_noise(type(each.effect))),
            files=files,
            photon_scale=prod(optional(each.effect, EffectBase, "photon_scale") for each in ordered),
            dark_scale=prod(
                scale(context)
                for each in ordered
                if callable(scale := optional(each.effect, EffectBase, "dark_scale"))
            ),
        )
