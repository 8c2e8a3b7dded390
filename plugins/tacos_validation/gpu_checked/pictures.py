"""Pictures of one scene taken in a process of its own, so that each device has an OpenGL of its own."""

from __future__ import annotations

import multiprocessing
import os
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import DEVICE_VARIABLE, Plugins, Recipe
from tacos_framework.plan import make_plan
from tacos_framework.simulation import EpisodeSpec, Simulation

LUMINANCE_TOLERANCE = 0.02
"""Pixels whose luminance differs by more than this share of the larger one differ [1]."""


@dataclass(frozen=True, eq=False)
class Pictures:
    renderer: str
    is_software: bool
    luminance_cd_m2: NDArray[np.float32]  # (N, H, W, 3) of the first camera
    depth_m: NDArray[np.float32]  # (N, H, W)
    object_id: NDArray[np.int32]  # (N, H, W)
    frames_per_s: float  # frames by the clock, the first left out, for which the world is lit [1/s]


@dataclass(frozen=True)
class Difference:
    """Difference of two devices' pictures."""

    ids: float
    """Share of the pixels with other ids [1]."""
    depth: float  # share where ids are the same and depth differs by more than 0.1 % [1]
    luminance: float  # share where it differs by more than `LUMINANCE_TOLERANCE` [1]


def taken_on(device: str, recipe: Recipe, values: dict[str, Any], frames: int) -> Pictures:
    """Pictures of a recipe's first camera on a device, ``auto`` or ``cpu``.

    Processes are spawned: OpenGL cannot be forked, and reads its device once.
    """
    context = multiprocessing.get_context("spawn")
    receiving, sending = context.Pipe(duplex=False)
    process = context.Process(target=_take, args=(sending, device, recipe, values, frames))
    process.start()
    sending.close()
    try:
        found = receiving.recv()
    except EOFError:
        process.join()
        raise RuntimeError(f"the process that renders on {device} ended with {process.exitcode}") from None
    process.join()
    if isinstance(found, Exception):
        raise found
    pictures: Pictures = found
    return pictures


def difference(one: Pictures, other: Pictures) -> Difference:
    same = one.object_id == other.object_id
    with np.errstate(invalid="ignore"):  # infinity less infinity
        apart = np.abs(one.depth_m - other.depth_m) > 1e-3 * np.minimum(one.depth_m, other.depth_m)
    light, theirs = one.luminance_cd_m2, other.luminance_cd_m2
    brighter = np.maximum(light, theirs)
    differs = (np.abs(light - theirs) > LUMINANCE_TOLERANCE * brighter).any(axis=-1)
    return Difference(float(1 - same.mean()), float((apart & same).mean()), float(differs.mean()))


def _take(sending: Any, device: str, recipe: Recipe, values: dict[str, Any], frames: int) -> None:
    """Runs in a process of its own."""
    if device != "auto":
        os.environ[DEVICE_VARIABLE] = device
    try:
        sending.send(_pictures(recipe, values, frames))
    except Exception as error:  # noqa: BLE001 - whatever it is, the caller gets it
        sending.send(error)
    sending.close()


def _pictures(recipe: Recipe, values: dict[str, Any], frames: int) -> Pictures:
    from tacos_plugins.renderers.moderngl.context import describe_gl

    simulation = Simulation(make_plan(recipe, Plugins.discover()))
    spec = EpisodeSpec(recipe.seed, ("gpu-check",), frames)
    shown, taken_at_s = [], []
    for at in range(frames):
        (view, *_) = simulation.sample(values, spec, at / max(1, frames - 1)).capture.views
        shown.append(view)
        taken_at_s.append(time.perf_counter())
    about = describe_gl()
    return Pictures(
        renderer=about.renderer,
        is_software=about.is_software,
        luminance_cd_m2=np.concatenate([view.luminance_cd_m2 for view in shown]),
        depth_m=np.concatenate([view.depth_m for view in shown]),
        object_id=np.concatenate([view.object_id for view in shown]),
        frames_per_s=(frames - 1) / max(1e-9, taken_at_s[-1] - taken_at_s[0]),
    )
