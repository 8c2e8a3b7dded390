"""The scene `scene.textured-target`: a sheet full of detail of all sizes, standing still or passing by."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, Material, Settings, Trajectory, setting
from tacos_framework.camera import srgb_from_linear
from tacos_worlds.bench.stand import square, standing, tent_world, turned

SMALLEST_PX, LARGEST_PX = 3.0, 300.0
"""Radii of the leaves [px of the texture]."""

_OF_WORLD = {
    "size_m",
    "distance_m",
    "tilt_deg",
    "turn_deg",
    "darkest",
    "brightest",
    "colourful",
    "texture_px",
}

_PAD_PX = 8  # discs are drawn less smoothly at the rim of an image, which is therefore cut off

BORDER = 1.0
"""Room for what passes by, in sizes of the target."""


class TexturedTarget:
    """A sheet of dead leaves: discs of all sizes and colours, each hiding what lies below it.

    Its spectrum is that of natural images and does not depend on scale, so that it holds detail at whatever
    distance it stands. The sheet may be tilted, which gives it depth. With a speed the camera passes it
    sideways, so that the target moves through the image evenly.

    Source: Lee, Mumford and Huang 2001, "Occlusion models for natural images", IJCV 41; Cao, Guichard and
    Hornung 2010, "Dead leaves model for measuring texture quality on a digital camera", SPIE 7537.
    """

    class Config(Settings):
        size_m: float = setting(0.6, help="Edge of the sheet that is seen.", unit="m", gt=0)
        distance_m: float = setting(0.5, help="From the camera to the sheet.", unit="m", gt=0)
        tilt_deg: float = setting(
            0.0, help="Turn about the horizontal; above 0 its top goes back.", unit="deg", ge=-80, le=80
        )
        turn_deg: float = setting(
            0.0, help="Turn about the vertical; above 0 its right goes back.", unit="deg", ge=-80, le=80
        )
        darkest: float = setting(0.05, help="Least reflectance of a leaf.", ge=0, le=1)
        brightest: float = setting(0.9, help="Greatest reflectance of a leaf.", gt=0, le=1)
        colourful: bool = setting(True, help="Leaves in colour, or in grey.")
        texture_px: int = setting(
            2048, help="Edge of the texture; a power of two.", unit="px", ge=64, le=8192
        )
        speed_m_s: float = setting(0.0, help="Speed of the camera.", unit="m/s")
        direction_deg: float = setting(
            0.0, help="Direction: 0 is to the left, so that the target goes right; 90 is up.", unit="deg"
        )
        frame_interval_s: float = setting(0.033, help="From frame to frame.", unit="s", gt=0)
        frames: int = setting(1, help="Frames taken.", ge=1, le=1_000_000)

    def __init__(self, config: Config) -> None:
        self.config = config

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        config = self.config
        number = int(rng.integers(2**32))
        leaves = dead_leaves(
            np.random.default_rng(number), config.texture_px, config.darkest, config.brightest
        )
        if not config.colourful:
            leaves = np.repeat(leaves[..., 1:2], 3, axis=-1)
        half_m = config.size_m * (0.5 + (BORDER if config.speed_m_s else 0.0))
        sheet = square(config.distance_m, half_m)
        material = Material(
            "leaves", np.ones(3, np.float32), texture=leaves, texture_size_m=config.size_m, roughness=1.0
        )
        world = tent_world(
            f"scene.textured-target {number} {half_m!r} {config.model_dump(include=_OF_WORLD)!r}",
            [turned(sheet, config.distance_m, tilt_deg=config.tilt_deg, turn_deg=config.turn_deg)],
            [material],
            illumination_lux=illumination_lux,
        )
        return self._passing(standing(world, config.frames))

    def _passing(self, still: Episode) -> Episode:
        """The episode with a camera that goes by; it is in the middle half way through."""
        config = self.config
        if not config.speed_m_s:
            return still
        time_s = config.frame_interval_s * np.arange(config.frames, dtype=np.float64)
        ends_s = np.array([-1.0, 1.0]) * (time_s[-1] / 2 + 1.0) + time_s[-1] / 2
        angle = math.radians(config.direction_deg)
        way_m = np.outer(ends_s - time_s[-1] / 2, np.array([0.0, math.cos(angle), math.sin(angle)]))
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[:, :3, 3] = way_m * config.speed_m_s
        return Episode(still.world, Trajectory(ends_s, poses), time_s, np.zeros(len(time_s), np.int32))


def dead_leaves(
    rng: np.random.Generator, size_px: int, darkest: float, brightest: float
) -> NDArray[np.uint8]:
    """(size, size, 3) uint8 sRGB-encoded leaves that tile; radii r have the density r^-3.

    `darkest`, `brightest`: least and greatest reflectance, spread evenly for each channel of each leaf [1].
    """
    import cv2

    largest = min(LARGEST_PX, size_px / 6)
    smallest = min(SMALLEST_PX, largest / 2)
    area = size_px**2
    # as many as leave a share of e^-6 of the sheet bare
    mean_area = 2 * np.pi * smallest**2 * np.log(largest / smallest) / (1 - (smallest / largest) ** 2)
    count = int(np.ceil(6 * area / mean_area))
    share = rng.random(count)
    radii = (smallest**-2 - share * (smallest**-2 - largest**-2)) ** -0.5
    centres = rng.uniform(0, size_px, (count, 2))
    greys = rng.uniform(darkest, brightest, (count, 1))
    colours = _encoded(np.clip(greys * rng.uniform(0.75, 1.25, (count, 3)), darkest, brightest))
    edge_px = size_px + 2 * _PAD_PX
    sheet = np.tile(_encoded(np.array((darkest + brightest) / 2)), (edge_px, edge_px, 3))
    for (x, y), radius, colour in zip(centres, radii, colours.tolist(), strict=True):
        for at_x in _copies(x, radius, size_px):
            for at_y in _copies(y, radius, size_px):
                centre = (round((at_x + _PAD_PX) * 16), round((at_y + _PAD_PX) * 16))
                cv2.circle(sheet, centre, round(radius * 16), colour, cv2.FILLED, cv2.LINE_AA, 4)
    return np.ascontiguousarray(sheet[_PAD_PX:-_PAD_PX, _PAD_PX:-_PAD_PX])


def _copies(place: float, radius: float, size_px: int) -> list[float]:
    """Places of a leaf on a sheet whose opposite edges meet."""
    copies = [place]
    reach = radius + _PAD_PX
    if place < reach:
        copies.append(place + size_px)
    if place > size_px - reach:
        copies.append(place - size_px)
    return copies


def _encoded(reflectance: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.rint(255 * srgb_from_linear(reflectance)).astype(np.uint8)
