"""The scene `scene.street`: a town by day or by night and a car driving through it."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import model_validator

from tacos_framework import Episode, Mover, setting
from tacos_worlds.kit.carried import CarriedSettings, carried, motion_words


class StreetScene:
    """A procedural town and a car with cameras on its roof.

    Streets cross at right angles and differ in spacing; between them stand rows of shops, houses and offices,
    one block is a park, and two footbridges lead over streets. Cars park at the kerbs, and others drive;
    people walk along the pavements. Sun and sky light it all, or, by night, street lamps: those near the
    agent's way light the street, while lit windows and the lights of cars are only seen. The car drives on
    the right-hand lanes between the inner crossings, goes straight on or turns at each, and slows down for
    it.

    One generator state gives one town and one drive, always; every other state gives other streets.

    >>> import numpy as np
    >>> scene = StreetScene(StreetScene.Config(blocks=1, frames=10))
    >>> len(scene.episode(rng=np.random.default_rng(7), illumination_lux=20_000.0))
    10
    """

    carrier: ClassVar[str] = "car"

    class Config(CarriedSettings):
        blocks: int = setting(
            3, help="Blocks between streets along each axis; the car drives around them.", ge=1, le=4
        )
        reach_m: float = setting(
            160.0, help="Length of the streets beyond the outermost crossings.", unit="m", ge=60, le=400
        )
        frames: int = setting(500, help="Frames taken along the drive.", ge=1, le=1_000_000, also=("steps",))
        frame_rate_hz: float = setting(
            2.0, help="Frames per second of driving.", unit="Hz", gt=0, also=("fps",)
        )
        speed_m_s: float = setting(
            11.0, help="Speed on straight ways; bends are taken slower.", unit="m/s", gt=0, le=30
        )
        camera_height_m: float = setting(
            2.0, help="Height of the agent's eye above the road.", unit="m", gt=0.3, le=4.0
        )
        sun_elevation_deg: tuple[float, float] = setting(
            (30.0, 60.0), help="Range from which the height of the sun is drawn.", unit="deg"
        )
        sun_share: float = setting(
            0.75, help="Share of the light on open ground that comes straight from the sun.", ge=0.05, le=0.95
        )
        clouds: float = setting(0.35, help="Cloud cover of the sky that is seen.", ge=0, le=1)
        greenery: float = setting(0.3, help="Share of the streets that are lined with trees.", ge=0, le=1)
        parked_share: float = setting(
            0.4,
            help="Share of the parking lots that are taken; in large towns only near the agent's way.",
            ge=0,
            le=1,
        )
        people: int = setting(24, help="People on the pavements; three in four walk.", ge=0, le=200)
        light: Literal["day", "dusk", "night"] = setting(
            "day",
            help="Sun and sky, the sky after sunset with street lamps on, or lamps and lit windows alone; "
            "illumination_lux of the scenario says how bright: about 20000, 25 and 10.",
        )
        texture_px: Literal[64, 128, 256, 512] = setting(
            512, help="Edge of the largest textures; less is built faster and looks coarser.", unit="px"
        )
        driving_cars: int = setting(12, help="Other cars that drive; no more than two a street.", ge=0, le=20)

        @model_validator(mode="after")
        def _sun_above_the_horizon(self) -> StreetScene.Config:
            low, high = self.sun_elevation_deg
            if not 5 <= low <= high <= 90:
                raise ValueError(
                    f"sun_elevation_deg must rise from 5 or more to 90 or less, not {low} to {high}"
                )
            return self

    def __init__(self, config: Config) -> None:
        self.config = config

    @property
    def moves(self) -> str:
        return motion_words(self.config, self.config.speed_m_s)

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """A new town and a drive through it.

        `illumination_lux`: mean illuminance on a plane 1 m above the streets between the outermost crossings,
        in sun and shadow; at dusk and by night above those that the car comes by [lux].
        """
        # Late: what builds worlds takes a while to import, and checking a recipe builds none.
        from tacos_worlds.kit.sky import draw_daylight
        from tacos_worlds.street.assembly import assemble
        from tacos_worlds.street.city import draw_town
        from tacos_worlds.street.crowd import populated
        from tacos_worlds.street.drive import draw_way, drive
        from tacos_worlds.street.finishes import StreetTextures
        from tacos_worlds.street.night import draw_dark_sky
        from tacos_worlds.street.streetscape import PlacedPiece, furnish_town
        from tacos_worlds.street.traffic import draw_traffic

        if not illumination_lux > 0:
            raise ValueError(f"illumination_lux must be above 0, not {illumination_lux}")
        config = self.config
        town_rng, thing_rng, texture_rng, sky_rng, drive_rng, traffic_rng, people_rng, shaking_rng = (
            rng.spawn(8)
        )
        town = draw_town(town_rng, blocks=config.blocks, reach_m=config.reach_m)
        dark = config.light != "day"
        if dark:
            sky = draw_dark_sky(sky_rng, light=config.light, clouds=config.clouds)
        else:
            sky = draw_daylight(
                sky_rng,
                elevation_deg=float(sky_rng.uniform(*config.sun_elevation_deg)),
                sun_share=config.sun_share,
                clouds=config.clouds,
            )
        duration_s = (config.frames - 1) / config.frame_rate_hz
        way = draw_way(drive_rng, town, config.speed_m_s * duration_s + 20.0)
        trajectory = drive(way, config.speed_m_s, config.camera_height_m)
        drivers = draw_traffic(traffic_rng, town, trajectory, duration_s, config.driving_cars, lamps=dark)
        placed = furnish_town(
            thing_rng, town, greenery=config.greenery, parked_share=config.parked_share, dark=dark
        )
        way_m = trajectory.at(np.arange(0.0, duration_s + 1.0))[:, :2, 3]
        placed, walkers = populated(
            people_rng,
            town,
            placed,
            way_m=way_m,
            people=config.people,
            duration_s=duration_s,
            driving=len(drivers),
        )
        moving = [(driver.piece, driver.trajectory) for driver in drivers] + walkers
        world = assemble(
            town,
            [*placed, *(PlacedPiece(piece, moves=True) for piece, _ in moving)],
            StreetTextures(texture_rng, config.texture_px),
            sky,
            illumination_lux,
            way_m if dark else None,
        )
        first = len(placed) + 1  # ids follow the background and what stands still
        trip = Episode(
            world=world,
            trajectory=trajectory,
            time_s=np.arange(config.frames) / config.frame_rate_hz,
            walk=np.zeros(config.frames, np.int32),
            movers=tuple(Mover(first + k, way) for k, (_, way) in enumerate(moving)),
        )
        return carried(shaking_rng, trip, config)
