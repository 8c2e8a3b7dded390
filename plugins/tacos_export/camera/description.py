"""A camera in files: geometry, lens, noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tacos_export.camera.lens import LensModel, described_lens
from tacos_export.camera.noise import NoiseDescription, describe_noise
from tacos_export.conventions import at_full_resolution
from tacos_framework import Camera, Lens, Rig, moves_pixels
from tacos_framework.formation import PlacedEffect
from tacos_plugins.effects.lens_distortion import LensDistortion
from tacos_view.cameras import built_rig
from tacos_view.setup import RenderSetup


@dataclass(frozen=True, eq=False)
class CameraDescription:
    camera: Camera
    lens: LensModel
    distortion: tuple[float, ...]
    """Its coefficients in OpenCV's order; zero where the simulation has no distortion."""
    noise: NoiseDescription
    limitations: tuple[str, ...] = ()  # in a sentence each, what the files cannot say of it


def describe_cameras(setup: RenderSetup, *, simulated: bool = False) -> tuple[CameraDescription, ...]:
    """The cameras of a rig, in its order.

    `simulated`: as they are simulated, where the rig averages blocks of photosites; otherwise with all
    pixels.
    """
    described = []
    rig = setup.rig if simulated else whole_rig(setup)
    for camera in rig.cameras:
        lens, distortion, limitations = lens_of(setup.effects, camera)
        shown = camera if simulated else at_full_resolution(camera)
        noise = describe_noise(setup.sensor.at(camera.name), shown, setup.exposure)
        described.append(CameraDescription(shown, lens, distortion, noise, limitations))
    return tuple(described)


def whole_rig(setup: RenderSetup) -> Rig:
    """The rig with every pixel, also those that are left over where blocks of them are averaged.

    A rig without the setting `binning` is as it is.
    """
    part = setup.plan.rig
    if getattr(part.config, "binning", 1) == 1:
        return setup.rig
    unbinned = replace(part, config=part.config.model_copy(update={"binning": 1.0}), built=None)
    return built_rig(replace(setup.plan, rig=unbinned), setup.camera)


def lens_of(
    effects: Sequence[PlacedEffect], camera: Camera
) -> tuple[LensModel, tuple[float, ...], tuple[str, ...]]:
    """Model and coefficients of a camera's lens, with the effect that distorts its images."""
    lens = described_lens(camera)
    model, coefficients, limitations = lens.model, lens.coefficients, [*lens.limitations]
    distorted = False
    for effect in effects:
        config = effect.config_at(camera.name)
        if config is None or not moves_pixels(effect.cls):
            continue
        if isinstance(config, LensDistortion.Config) and not distorted and _is_told(config, camera.lens):
            distorted = True
            c, own = config, coefficients if not camera.lens.is_rectilinear else (0.0,) * 4
            model = c.model
            powers = tuple(a + b for a, b in zip(own, (c.k1, c.k2, c.k3, c.k4), strict=True))
            coefficients = powers if model == "fisheye" else (c.k1, c.k2, c.p1, c.p2, c.k3)
        else:
            limitations.append(
                f"{effect.name} moves pixels too, which the lens model of these files cannot say"
            )
    return model, coefficients, tuple(limitations)


def _is_told(distortion: LensDistortion.Config, lens: Lens) -> bool:
    """True if one model of a lens tells of a distortion on top of a lens."""
    return lens.is_pinhole or (distortion.model == "fisheye" and not lens.is_rectilinear)


def second_from_first(first: Camera, second: Camera) -> NDArray[np.float64]:
    """(4, 4) pose that takes points of the first camera's frame to the second's [m]."""
    from tacos_framework.camera import invert_pose

    return np.asarray(invert_pose(second.agent_from_camera) @ first.agent_from_camera)
