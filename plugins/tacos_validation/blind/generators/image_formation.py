"""Images as a camera with injected effects forms them."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tacos_validation.blind.generators.camera import PAD_PX, IdealShot, Image
from tacos_validation.blind.generators.injected_effect import InjectedEffect


def seen(shot: IdealShot, effects: Sequence[InjectedEffect], pad: int = 0) -> Image:
    """Light that arrives at the sensor's pixels, geometry included, (H + 2 pad, W + 2 pad, C)."""
    x, y = shot.camera.grid(pad)
    planes = []
    for channel in range(shot.camera.channels):
        at_x, at_y = x, y
        for effect in sorted(effects, key=lambda f: f.place):
            at_x, at_y = effect.rays(at_x, at_y, channel, shot, y)
        planes.append(shot.look(at_x, at_y, channel))
    return np.stack(planes, axis=-1)


def expected(shot: IdealShot) -> Image:
    """Image of the ideal camera without noise, (H, W, C) [DN, with pedestal]."""
    return seen(shot, ()) + shot.camera.black_dn


def take(
    shot: IdealShot,
    effects: Sequence[InjectedEffect],
    frames: int,
    rng: np.random.Generator,
    sensor_seed: int,
) -> Image:
    """Frames of the camera with injected effects, (N, H, W, C) whole numbers [DN].

    `rng`: draws what differs from frame to frame. `sensor_seed`: draws what belongs to the individual sensor.
    """
    ordered = sorted(effects, key=lambda f: f.place)
    camera = shot.camera
    blurs = any(type(effect).light is not InjectedEffect.light for effect in ordered)
    pad = PAD_PX if blurs else 0
    light = seen(shot, ordered, pad)
    for effect in ordered:
        light = effect.light(light, shot, pad)
    if pad:
        light = light[pad:-pad, pad:-pad]
    return np.stack([_frame(light, shot, ordered, rng, sensor_seed) for _ in range(frames)]).clip(
        0, camera.white_dn
    )


def _frame(
    light: Image,
    shot: IdealShot,
    effects: Sequence[InjectedEffect],
    rng: np.random.Generator,
    sensor_seed: int,
) -> Image:
    camera = shot.camera
    for effect in effects:
        light = effect.frame_light(light, shot, rng)
    mean = light
    for effect in effects:
        mean = effect.charge(mean, shot, _sensor(sensor_seed, effect.name))
    gain = camera.photon_dn * shot.gain * float(np.prod([effect.photon_factor for effect in effects]))
    electrons = rng.poisson(np.maximum(mean, 0) / gain)
    samples = electrons * gain + np.minimum(mean, 0)
    dark_factor = float(np.prod([effect.dark_factor(shot) for effect in effects]))
    dark_dn = np.sqrt(camera.thermal_dn2) * shot.gain * dark_factor
    samples = samples + rng.normal(camera.black_dn, dark_dn, size=samples.shape)
    for effect in effects:
        samples = effect.samples(samples, shot, rng)
    codes = np.clip(np.floor(samples + 0.5), 0, camera.white_dn)
    for effect in effects:
        if type(effect).codes is not InjectedEffect.codes:
            codes = effect.codes(codes, shot, _sensor(sensor_seed, effect.name))
            codes = np.clip(np.floor(codes + 0.5), 0, camera.white_dn)
    return codes


def _sensor(seed: int, name: str) -> np.random.Generator:
    """Generator of one sensor's fixed pattern: anew and the same each time."""
    return np.random.default_rng([seed, zlib.crc32(name.encode())])


def moved(shot: IdealShot, seconds: float) -> IdealShot:
    vx, vy = shot.velocity_px_s
    look = shot.look
    return replace(shot, look=lambda x, y, channel: look(x - vx * seconds, y - vy * seconds, channel))
