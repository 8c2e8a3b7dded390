"""The scene `scene.indoor`: furnished rooms and a walk through them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from tacos_framework import Episode, setting
from tacos_worlds.kit.carried import CarriedSettings, carried, motion_words
from tacos_worlds.kit.piece import Piece

if TYPE_CHECKING:
    from tacos_worlds.indoor.building import Building
    from tacos_worlds.kit.walk.trip import Stretch

Metres = Annotated[float, Field(gt=0)]
Seconds = Annotated[float, Field(gt=0)]
Share = Annotated[float, Field(ge=0, le=1)]


class IndoorScene:
    """Procedural furnished rooms, and an agent that walks through all of them.

    The floor is cut into rooms joined by doors with gold-coloured thresholds. Rooms get furniture of ten
    classes that suits their use, and ceiling lights and lamps scaled to the scenario's illuminance. The agent
    walks a tour of all rooms; a second walk starts where the frames outlast the first.

    Under ``sampling: walk`` frames are taken at a steady rate, as a recording has them. Under ``bursts`` a
    few follow one another, and the next few are taken far from there: as many frames see more of the world.
    Under ``approaches`` they are taken only before thresholds, at the times ``before_step_s``: few frames
    then see several thresholds, each from an eye height of its own. Every burst and every approach is a walk
    to those who follow things from frame to frame; the threshold of an approach is the one obstacle that
    counts in it.

    One generator state gives one world and one trip, always.

    >>> import numpy as np
    >>> scene = IndoorScene(IndoorScene.Config(size_m=(8, 6), frames=10))
    >>> len(scene.episode(rng=np.random.default_rng(7), illumination_lux=20.0))
    10
    """

    carrier: ClassVar[str] = "person"

    class Config(CarriedSettings):
        size_m: tuple[Metres, Metres] = setting(
            (15.0, 15.0), help="Extent of the floor along x and y.", unit="m"
        )
        ceiling_height_m: float = setting(3.0, help="Height of the rooms.", unit="m", ge=2.4, le=6.0)
        min_room_m: float = setting(
            5.0, help="Least edge of a room, to the middle of inner walls.", unit="m", ge=3.5
        )
        frames: int = setting(500, help="Frames taken in all.", ge=1, le=1_000_000, also=("steps",))
        sampling: Literal["walk", "bursts", "approaches"] = setting(
            "walk",
            help="Places of the frames: all along the walk, in short bursts spread over it, or only before "
            "thresholds.",
        )
        frame_rate_hz: float = setting(
            5.0,
            help="Frames per second of walking, under sampling: walk and within a burst.",
            unit="Hz",
            gt=0,
            also=("fps",),
        )
        burst_frames: int = setting(2, help="Frames of a burst, under sampling: bursts.", ge=2)
        before_step_s: tuple[Seconds, ...] = setting(
            (1.6, 1.4, 0.8, 0.6),
            help="Times before a threshold is stepped on, falling, under sampling: approaches. "
            "frames should be a multiple of their number.",
            unit="s",
            min_length=1,
        )
        speed_m_s: float = setting(1.0, help="Speed of the agent on straight ways.", unit="m/s", gt=0, le=5.0)
        camera_height_m: tuple[Metres, Metres] = setting(
            (1.0, 2.0), help="Range from which each walk draws the height of the agent's eye.", unit="m"
        )
        room_light: tuple[Share, ...] = setting(
            (1.0,),
            help="Light of the rooms over that of the brightest, one after the other in turn: [1, 0.02] has "
            "every other room dark. The mean illuminance of the scenario stays that over all rooms.",
            min_length=1,
        )
        clutter: float = setting(
            0.5,
            help="Amount of toys on the floor, and of small things on tables and worktops.",
            ge=0.0,
            le=1.0,
        )
        people: float = setting(
            0.4,
            help="Mean number of people in a room, sitting or standing; none in bathrooms.",
            ge=0.0,
            le=4.0,
        )
        furniture_folder: str = setting(
            "",
            help="Folder of GLB or OBJ models, CLASS/NAME.glb, that replace the built-in furniture.",
            is_path=True,
        )

        @model_validator(mode="after")
        def _fits(self) -> IndoorScene.Config:
            if min(self.size_m) < self.min_room_m:
                raise ValueError(f"size_m {self.size_m} is smaller than min_room_m {self.min_room_m}")
            low, high = self.camera_height_m
            if low > high:
                raise ValueError(f"camera_height_m must rise from low to high, not {self.camera_height_m}")
            if high > self.ceiling_height_m - 0.2:
                raise ValueError(
                    f"camera_height_m reaches {high} m, but must stay 0.2 m below the ceiling of "
                    f"{self.ceiling_height_m} m"
                )
            if not any(self.room_light):
                raise ValueError("room_light is 0 for every room: no factor gives them the illuminance")
            if any(later >= earlier for earlier, later in pairwise(self.before_step_s)):
                raise ValueError(f"before_step_s must fall from time to time, not {self.before_step_s}")
            if self.sampling == "approaches" and max(self.size_m) < 2 * self.min_room_m:
                raise ValueError(
                    f"sampling is approaches, but size_m {self.size_m} is a single room without thresholds: "
                    f"it takes two rooms of min_room_m {self.min_room_m}"
                )
            return self

    def __init__(self, config: Config) -> None:
        self.config = config
        self._pieces: Mapping[str, Sequence[Piece]] = {}
        self._images: Mapping[int, NDArray[np.uint8]] = {}
        self.remarks: tuple[str, ...] = ()
        if config.furniture_folder:
            from tacos_worlds.indoor.user_models import load_user_models

            models = load_user_models(config.furniture_folder)
            self._pieces, self._images = models.pieces, models.images
            self.remarks = tuple(models.notes)

    @property
    def moves(self) -> str:
        return motion_words(self.config, self.config.speed_m_s)

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """A new world and a trip through it.

        `illumination_lux`: mean illuminance on a plane 1 m above the floors of all rooms [lux].
        """
        # Late: what builds worlds takes a while to import, and checking a recipe builds none.
        from tacos_worlds.indoor.assembly import assemble
        from tacos_worlds.indoor.building import draw_building
        from tacos_worlds.indoor.furnishing.catalogue import Catalogue
        from tacos_worlds.kit.finishes import TextureLibrary
        from tacos_worlds.kit.walk.trip import joined

        if not illumination_lux > 0:
            raise ValueError(f"illumination_lux must be above 0, not {illumination_lux}")
        config = self.config
        building_rng, texture_rng, walk_rng, shaking_rng = rng.spawn(4)
        building = draw_building(
            building_rng,
            size_m=config.size_m,
            ceiling_height_m=config.ceiling_height_m,
            min_room_m=config.min_room_m,
            clutter=config.clutter,
            people=config.people,
            catalogue=Catalogue(self._pieces),
            room_light=config.room_light,
        )
        world = assemble(building, TextureLibrary(texture_rng), self._images, illumination_lux)
        world = replace(world, remarks=self.remarks)
        trip = joined(world, self._stretches(walk_rng, building))
        return carried(shaking_rng, trip, config)

    def _stretches(self, rng: np.random.Generator, building: Building) -> Iterator[Stretch]:
        from tacos_worlds.indoor.walk.walks import draw_walks
        from tacos_worlds.kit.walk.trip import along_walks, approaches, bursts

        config = self.config
        if config.sampling != "approaches":
            walks = draw_walks(rng, building, config.speed_m_s, config.camera_height_m)
            frames, rate_hz = config.frames, config.frame_rate_hz
            if config.sampling == "walk":
                return along_walks(rng, walks, frames=frames, frame_rate_hz=rate_hz)
            return bursts(rng, walks, frames=frames, burst_frames=config.burst_frames, frame_rate_hz=rate_hz)
        walks = draw_walks(rng, building, config.speed_m_s, camera_height_m=(0.0, 0.0))
        return approaches(
            rng,
            walks,
            frames=config.frames,
            before_s=config.before_step_s,
            camera_height_m=config.camera_height_m,
        )
