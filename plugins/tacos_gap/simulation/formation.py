"""Captures simulated by the image formation of studies, on arrays, frame by frame.

What stands still is simulated once up to the noise: effects that neither draw anything nor remember a frame
give each frame of a still the same samples.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import (
    ContextMissing,
    EffectBase,
    ImageContext,
    ImageGeometry,
    moves_pixels,
    optional,
)
from tacos_framework.camera import Places, composed, resample
from tacos_framework.formation import ActingEffect, EffectChain, EpisodeDraws, PlacedEffect, form_files
from tacos_gap.captures import RealCapture
from tacos_gap.nuisances.mosaic import resampled_mosaic
from tacos_gap.simulation.kept_light import KeptLight
from tacos_gap.simulation.sensors import dark_signal, sensor_at
from tacos_plugins.effects.mosaic import bilinear, mosaic
from tacos_plugins.effects.shown_by import COLOURS, EDGES, FALL_OFF
from tacos_plugins.sensors.kept_numbers import KeptNumbers

Samples = NDArray[np.float32]
_SCALE_LIGHT = frozenset({COLOURS, FALL_OFF})
"""What shows effects that make light brighter or darker by a factor, of places or of colours."""

Step = Callable[[Samples, EpisodeDraws, int], Samples]
"""Samples of one frame, draws, number of the frame -> samples a step further."""


def simulate(
    capture: RealCapture,
    effects: Sequence[PlacedEffect],
    draws: EpisodeDraws,
    frames: int | None = None,
    kept: KeptNumbers | None = None,
    light: KeptLight | None = None,
) -> Samples:
    """Frames the simulator would have given instead of the real ones.

    - `effects`: effects as a recipe places them, in any order. Those that need what is not known of the
      capture, as motion of a still, are left out.
    - `draws`: generators by frame: the same draws give noise that is comparable between hypotheses.
    - `frames`: how many; as many as are real by default.
    - `kept`: remembers the noise of these draws, where it is asked for again and again.
    - `light`: remembers the light of this very capture, where it is simulated again and again.

    Returns: (N, H, W, C) float32 values of the file: whole numbers within its levels [DN].
    """
    assert capture.expected_dn is not None
    expected = capture.expected_dn
    draws = EpisodeDraws(draws.seed, draws.names)  # nothing is remembered of another simulation
    sensor = sensor_at(capture, kept)
    context = replace(capture.context, dn_per_electron=sensor.context.dn_per_electron)
    chain = _chain(effects, capture, context)
    told = {(each.use, each.name): f"{each.use} {each.config!r}" for each in effects}
    pedestal = np.float32(context.black_level_dn) - dark_signal(sensor, expected.shape[-1])
    pedestal = np.tile(pedestal, (expected.shape[2], 1))  # numpy is several times slower along three channels

    def light_of(frame: int) -> Samples:
        place = frame if len(expected) > 1 else 0
        return expected[place : place + 1] - np.float32(context.black_level_dn)

    def acting(effect: ActingEffect) -> Step:
        return _step_of(effect, capture.geometry, context)

    def words(acting: Iterable[ActingEffect]) -> str:
        return "; ".join(told[each.use, each.name] for each in acting)

    moving = list(takewhile(lambda each: moves_pixels(type(each.effect)), chain.light))
    further = chain.light[len(moving) :]
    if capture.own_edges:  # edges that were read off the pictures lie where the lens has put them
        moving = []
    on_light = _on_light(map(acting, further), context.cfa)
    named = [words([each]) for each in further] if len(on_light) == len(further) else [words(further)]
    steps: list[tuple[str, Step]] = [
        *([(words(moving), _moved_at_once(moving, capture, context))] if moving else []),
        *zip(named, on_light, strict=True),
        ("pedestal", lambda samples, draws, frame: samples + pedestal),
        *((words([each]), acting(each)) for each in chain.pixel),
    ]
    shared, done = None, 0
    if len(expected) == 1 and not any(_per_frame(context)):
        shared, done = _shared(light_of(0), steps, draws, light or KeptLight(0))
    after_pixel = replace(chain, light=(), pixel=())
    count = frames or capture.frames
    files = np.empty((count, *expected.shape[1:]), np.float32)
    for frame in range(count):
        signal = light_of(frame) if shared is None else shared
        for _, step in steps[done:]:
            signal = step(signal, draws, frame)
        files[frame] = form_files(
            signal,
            after_pixel,
            sensor,
            geometry=capture.geometry,
            context=_of_frame(context, frame),
            draws=draws,
            frame=frame,
        )[0]
    return files


def lit_by(
    capture: RealCapture, effects: Sequence[PlacedEffect], light: Samples, draws: EpisodeDraws
) -> Samples:
    """One frame of light with effects on it, (1, H, W, C)."""
    chain = _chain(effects, capture, capture.context)
    steps = [_step_of(effect, capture.geometry, capture.context) for effect in chain.light]
    for step in _on_light(steps, capture.context.cfa):
        light = step(light, draws, 0)
    return light


def _moved_at_once(moving: Sequence[ActingEffect], capture: RealCapture, context: ImageContext) -> Step:
    """Effects that move pixels as one step, with the pose of the expectation: what is read once keeps detail.

    Of a mosaic each plane of one colour is read by itself, as nuisances read it.
    """
    unmoved = capture.unmoved if context.cfa is None else None

    def step(samples: Samples, draws: EpisodeDraws, frame: int) -> Samples:
        places: Places | None = None
        for effect in moving:
            known = _of_frame(context, frame)
            source = effect.source(geometry=capture.geometry, context=known, frames=1)
            if source is not None:
                places = source if places is None else composed(places, source)
        if places is None:
            return samples
        if context.cfa is not None:
            return resampled_mosaic(samples, places)
        if unmoved is None:
            return resample(samples, *places)
        still = unmoved.expected_dn[frame if len(unmoved.expected_dn) > 1 else 0][None]
        return resample(still - np.float32(context.black_level_dn), *composed(unmoved.source, places))

    return step


def _step_of(effect: ActingEffect, geometry: ImageGeometry, context: ImageContext) -> Step:
    def step(samples: Samples, draws: EpisodeDraws, frame: int) -> Samples:
        known = _of_frame(context, frame)
        return effect.on(samples, geometry=geometry, context=known, draws=draws, frame=frame)

    return step


# mosaics --------------------------------------------------------------------------------------------------


def _on_light(acting: Iterable[Step], cfa: str | None) -> list[Step]:
    """Steps on light, which has all colours everywhere, also where a mosaic samples one of them.

    Blur and whatever moves light would mix the colours of neighbouring photosites. Each colour is a picture
    of one channel, as the file is. What a mosaic has sampled is kept to the bit where nothing acts.
    """
    steps = list(acting)
    if cfa is None or not steps:
        return steps

    def by_colour(samples: Samples, draws: EpisodeDraws, frame: int) -> Samples:
        light = np.stack([np.asarray(bilinear(each[..., 0], cfa), np.float32) for each in samples])
        for colour in range(light.shape[-1]):
            plane = light[..., colour : colour + 1]
            for step in steps:
                plane = step(plane, draws, frame)
            light[..., colour] = plane[..., 0]
        return np.stack([np.asarray(mosaic(each, cfa), np.float32)[..., None] for each in light])

    return [by_colour]


# what stands still ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Watched(EpisodeDraws):
    _given: list[tuple[np.random.Generator, Any]] = field(default_factory=list, repr=False, compare=False)

    def rng(self, frame: int, *what: str) -> np.random.Generator:
        rng = super().rng(frame, *what)
        self._given.append((rng, _state(rng)))
        return rng

    @property
    def used(self) -> bool:
        """True if a generator has moved on, or anything is remembered."""
        return any(self._memories.values()) or any(_state(rng) != before for rng, before in self._given)


def _state(rng: np.random.Generator) -> Any:
    seeds: Any = rng.bit_generator.seed_seq
    return rng.bit_generator.state, seeds.n_children_spawned


def _shared(
    light: Samples, steps: Sequence[tuple[str, Step]], draws: EpisodeDraws, known: KeptLight
) -> tuple[Samples, int]:
    names = [name for name, _ in steps]
    for done, (_, step) in enumerate(steps):
        before = light

        def made(step: Step = step, before: Samples = before) -> Samples | None:
            watched = _Watched(draws.seed, draws.names)
            after = step(before, watched, 0)
            return None if watched.used else after

        if (after := known.after(names[: done + 1], made)) is None:
            return light, done
        light = after
    return light, len(steps)


# what is known --------------------------------------------------------------------------------------------


class _WhereKnown(ActingEffect):
    def source(self, *, geometry: ImageGeometry, context: ImageContext, frames: int) -> Places | None:
        try:
            return super().source(geometry=geometry, context=context, frames=frames)
        except ContextMissing:
            return None

    def on(
        self,
        samples: NDArray[Any],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        draws: EpisodeDraws,
        frame: int,
    ) -> NDArray[Any]:
        try:
            return super().on(samples, geometry=geometry, context=context, draws=draws, frame=frame)
        except ContextMissing:
            return samples


def _chain(effects: Sequence[PlacedEffect], capture: RealCapture, context: ImageContext) -> EffectChain:
    acting = [each for each in effects if not _is_in_expectation(each.cls, capture)]
    return _where_known(EffectChain.of(acting, capture.geometry, context))


def _is_in_expectation(cls: type[Any], capture: RealCapture) -> bool:
    """True of an effect that has acted on what is expected already, as that was read off the pictures.

    The sides of an edge are as bright as seen, the light of a bracket is all that is alike at every time.
    """
    if not (capture.own_edges or capture.own_light):
        return False
    shown_by = optional(cls, EffectBase, "shown_by")
    if not _SCALE_LIGHT.isdisjoint(shown_by):
        return True
    sharpens = cls.stage == "isp" and EDGES in shown_by
    return bool(capture.own_light) and (sharpens or cls.stage in ("scene", "optics"))


def _where_known(chain: EffectChain) -> EffectChain:
    def lenient(acting: Sequence[ActingEffect]) -> tuple[ActingEffect, ...]:
        return tuple(_WhereKnown(each.use, each.name, each.effect) for each in acting)

    return replace(
        chain,
        light=lenient(chain.light),
        pixel=lenient(chain.pixel),
        readout=lenient(chain.readout),
        files=lenient(chain.files),
    )


def _per_frame(context: ImageContext) -> tuple[bool, bool]:
    """For depth and for motion: True if given frame by frame."""
    depth, velocity = context.depth_m, context.velocity_px_s
    return depth is not None and depth.ndim == 3, isinstance(velocity, np.ndarray) and velocity.ndim == 4


def _of_frame(context: ImageContext, frame: int) -> ImageContext:
    depth_varies, motion_varies = _per_frame(context)
    known: dict[str, Any] = {}
    if depth_varies and context.depth_m is not None:
        known["depth_m"] = context.depth_m[frame]
    if motion_varies and isinstance(context.velocity_px_s, np.ndarray):
        known["velocity_px_s"] = context.velocity_px_s[frame]
    return replace(context, **known) if known else context
