"""Takes pictures with a flawed camera."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tacos_validation.blind.generators.camera import PAD_PX, Image, Shot
from tacos_validation.blind.generators.flaw import Flaw


def seen(shot: Shot, flaws: Sequence[Flaw], pad: int = 0) -> Image:
    """Light that arrives at the sensor's pixels, geometry included, (H + 2 pad, W + 2 pad, C)."""
    x, y = shot.camera.grid(pad)
    planes = []
    for channel in range(shot.camera.channels):
        at_x, at_y = x, y
        for flaw in sorted(flaws, key=lambda f: f.order):
            at_x, at_y = flaw.rays(at_x, at_y, channel, shot, y)
        planes.append(shot.look(at_x, at_y, channel))
    return np.stack(planes, axis=-1)


def expected(shot: Shot) -> Image:
    """What the flawless camera would give without noise, (H, W, C) [DN, with pedestal]."""
    return seen(shot, ()) + shot.camera.black_dn


def take(shot: Shot, flaws: Sequence[Flaw], frames: int, rng: np.random.Generator, sensor_seed: int) -> Image:
    """Frames of the flawed camera, (N, H, W, C) whole numbers [DN].

    Parameters
    ----------
    shot
        What is taken.
    flaws
        What is wrong.
    frames
        How many.
    rng
        Draws what differs from frame to frame.
    sensor_seed
        Draws what belongs to the individual sensor.
    """
    ordered = sorted(flaws, key=lambda f: f.order)
    camera = shot.camera
    blurs = any(type(flaw).light is not Flaw.light for flaw in ordered)
    pad = PAD_PX if blurs else 0
    light = seen(shot, ordered, pad)
    for flaw in ordered:
        light = flaw.light(light, shot, pad)
    if pad:
        light = light[pad:-pad, pad:-pad]
    return np.stack([_frame(light, shot, ordered, rng, sensor_seed) for _ in range(frames)]).clip(
        0, camera.white_dn
    )


def _frame(
    light: Image, shot: Shot, flaws: Sequence[Flaw], rng: np.random.Generator, sensor_seed: int
) -> Image:
    camera = shot.camera
    for flaw in flaws:
        light = flaw.frame_light(light, shot, rng)
    mean = light
    for flaw in flaws:
        mean = flaw.charge(mean, shot, _sensor(sensor_seed, flaw.name))
    gain = camera.photon_dn * float(np.prod([flaw.photon_factor for flaw in flaws]))
    electrons = rng.poisson(np.maximum(mean, 0) / gain)
    samples = electrons * gain + np.minimum(mean, 0)
    samples = samples + rng.normal(camera.black_dn, np.sqrt(camera.thermal_dn2), size=samples.shape)
    for flaw in flaws:
        samples = flaw.samples(samples, shot, rng)
    codes = np.clip(np.floor(samples + 0.5), 0, camera.white_dn)
    for flaw in flaws:
        if type(flaw).codes is not Flaw.codes:
            codes = flaw.codes(codes, shot, _sensor(sensor_seed, flaw.name))
            codes = np.clip(np.floor(codes + 0.5), 0, camera.white_dn)
    return codes


def _sensor(seed: int, name: str) -> np.random.Generator:
    """What is alike in all frames of one sensor, drawn anew and the same each time."""
    return np.random.default_rng([seed, zlib.crc32(name.encode())])


def moved(shot: Shot, seconds: float) -> Shot:
    """The same a little later: what is seen has moved on."""
    vx, vy = shot.velocity_px_s
    look = shot.look
    return replace(shot, look=lambda x, y, channel: look(x - vx * seconds, y - vy * seconds, channel))
