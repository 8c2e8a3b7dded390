"""Effects on the light of rendered views; where they move pixels, truth moves along."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.motion import FrameMotion, Places, image_velocity, inverse_depth
from tacos_framework.camera.resampling import nearest, resample, resample_inverse_depth
from tacos_framework.contracts import EffectBase, moves_pixels, optional
from tacos_framework.formation.chain import ActingEffect
from tacos_framework.formation.checked import checked_samples
from tacos_framework.formation.draws import EpisodeDraws
from tacos_framework.plugins.guarded import calling
from tacos_framework.values import TRUTHS, Episode, Exposure, ImageContext, ImageGeometry, View


def light_context(view: View, episode: Episode, exposure: Exposure) -> ImageContext:
    """The context of a rendered view; its middle row is the one that shows the moment of the frame."""
    known = set(TRUTHS) - set(episode.absent)
    moves = {"poses", "depth"} <= known
    return ImageContext(
        exposure_s=exposure.time_s,
        gain_db=exposure.gain_db,
        f_number=exposure.f_number,
        depth_m=view.depth_m if "depth" in known else None,
        object_id=view.object_id if "objects" in known else None,
        motion=FrameMotion.of(view, episode) if moves and len(episode) == 1 else None,
        shutter=view.camera.shutter,
        row_time_us=view.camera.row_time_us,
        row_time_at_most_us=view.camera.row_time_at_most_us,
        velocity_px_s=partial(image_velocity, view, episode) if moves else None,
        reference_row=(view.camera.height_px - 1) / 2,
    )


def with_light_effects(
    view: View, episode: Episode, effects: Sequence[ActingEffect], exposure: Exposure, draws: EpisodeDraws
) -> View:
    """A view with effects on its light, frame by frame.

    Returns: the view itself where every effect is off.
    """
    return joined([_frame(view, episode, effects, exposure, draws, i) for i in range(len(episode))], view)


def _frame(
    view: View,
    whole: Episode,
    effects: Sequence[ActingEffect],
    exposure: Exposure,
    draws: EpisodeDraws,
    index: int,
) -> View:
    """One frame of a view with the effects."""
    frame = view if len(view.depth_m) == 1 else view.frame(index)
    episode = whole[index : index + 1]
    geometry = ImageGeometry.of_camera(view.camera)
    for acting in effects:
        context = light_context(frame, episode, exposure)
        if moves_pixels(type(acting.effect)):
            frame = _moved(frame, acting, geometry, context)
            continue
        if callable(optional(acting.effect, EffectBase, "on_view")):
            frame = _seen_anew(frame, acting, geometry, context)
            continue
        light = acting.on(
            frame.luminance_cd_m2, geometry=geometry, context=context, draws=draws, frame=episode.first_frame
        )
        if light is not frame.luminance_cd_m2:
            frame = replace(frame, luminance_cd_m2=light)
    return frame


def _seen_anew(view: View, acting: ActingEffect, geometry: ImageGeometry, context: ImageContext) -> View:
    """A view with light, depth and ids of an effect that changes all three."""
    given = view.luminance_cd_m2, view.depth_m, view.object_id
    with calling(acting.use, doing="on_view"):
        light, depth_m, object_id = acting.effect.on_view(*given, geometry=geometry, context=context)
        if light is given[0]:
            return view
        light = checked_samples(acting.use, light, given[0])
    return replace(view, luminance_cd_m2=light, depth_m=depth_m, object_id=object_id)


def joined(frames: Sequence[View], view: View) -> View:
    """The frames of a view together; the view itself where none has changed."""
    if len(frames) == 1:
        return frames[0]
    names = ("luminance_cd_m2", "depth_m", "object_id")
    changed: dict[str, Any] = {
        name: np.concatenate([getattr(frame, name) for frame in frames])
        for name in names
        if any(not np.shares_memory(getattr(frame, name), getattr(view, name)) for frame in frames)
    }
    return replace(view, **changed) if changed else view


def _moved(view: View, acting: ActingEffect, geometry: ImageGeometry, context: ImageContext) -> View:
    """A view with light, depth and object ids fetched from elsewhere; its camera stays what tasks believe."""
    with calling(acting.use, doing="source"):
        places: Places | None = acting.effect.source(
            geometry=geometry, context=context, frames=len(view.depth_m)
        )
        if places is None:
            return view
        near: NDArray[np.floating] = resample_inverse_depth(inverse_depth(view.depth_m), *places)
        if callable(moved := optional(acting.effect, EffectBase, "moved_inverse_depth")):
            near = moved(near, *places, geometry=geometry)
    with np.errstate(divide="ignore"):
        depth_m = 1.0 / near
    return replace(
        view,
        luminance_cd_m2=resample(view.luminance_cd_m2, *places),
        depth_m=depth_m.astype(np.float32),
        object_id=nearest(view.object_id, *places),
    )
