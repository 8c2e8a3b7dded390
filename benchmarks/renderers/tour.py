"""What all renderers draw: poses of a camera on the way through a world where nothing else moves."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, Episode
from tacos_framework.camera import agent_from_camera, world_from_camera
from tacos_worlds.indoor.scene import IndoorScene
from tacos_worlds.street.scene import StreetScene

SCENES = ("indoor", "street")


@dataclass(frozen=True, eq=False)
class Tour:
    """Frames of an episode, spread over the whole way.

    Parameters
    ----------
    scene
        Its name, one of `SCENES`.
    episode
        The episode.
    camera
        The camera, its principal point in the middle.
    frames
        (F,) which of the episode's frames.
    """

    scene: str
    episode: Episode
    camera: Camera
    frames: NDArray[np.intp]

    @property
    def poses(self) -> NDArray[np.float64]:
        """(F, 4, 4) camera to world, in the camera's x to the right, y down, z ahead [m]."""
        agent = self.episode.trajectory.at(self.episode.time_s[self.frames])
        return world_from_camera(agent, self.camera.agent_from_camera)

    @property
    def reach_m(self) -> float:
        """A depth beyond all surfaces [m]."""
        corners = np.array(
            [part.vertices_m.max(axis=0) for part in self.episode.world.parts]
            + [part.vertices_m.min(axis=0) for part in self.episode.world.parts]
        )
        return float(np.linalg.norm(np.ptp(corners, axis=0)))


def benchmark_camera(width_px: int, height_px: int, pitch_deg: float = -10.0) -> Camera:
    """A camera of 77 degrees across, which looks a little down."""
    return Camera(
        name="benchmark",
        width_px=width_px,
        height_px=height_px,
        pixel_um=3840.0 / width_px,
        focal_length_mm=2.4,
        agent_from_camera=agent_from_camera((0.0, 0.0, 0.0), pitch_deg=pitch_deg),
    )


def make_tour(scene: str, size: tuple[int, int], frames: int, seed: int) -> Tour:
    """A tour of a scene as it comes, without what moves by itself, which each renderer does otherwise."""
    rng = np.random.default_rng(seed)
    if scene == "indoor":
        episode = IndoorScene(IndoorScene.Config()).episode(rng=rng, illumination_lux=20.0)
    else:
        still = StreetScene.Config(people=0, driving_cars=0)
        episode = StreetScene(still).episode(rng=rng, illumination_lux=20_000.0)
    assert not episode.movers
    return Tour(
        scene, episode, benchmark_camera(*size), np.linspace(0, len(episode) - 1, frames).astype(np.intp)
    )


def parse_size(text: str) -> tuple[int, int]:
    """(640, 480) of "640x480", for a command line."""
    width, _, height = text.partition("x")
    try:
        return int(width), int(height)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form 640x480") from None
