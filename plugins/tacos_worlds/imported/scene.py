"""The scene `scene.imported`: a world of the user's own, and ways through it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Episode, UserError
from tacos_worlds.imported.settings import ImportedSettings

if TYPE_CHECKING:
    from tacos_worlds.imported.walkable_place import Place
    from tacos_worlds.kit.walk.trip import Stretch


class ImportedScene:
    """A room, a building or a street from a file, and an agent that walks through it.

    The file is a glTF 2.0 (``.glb``, ``.gltf``), OBJ, PLY or STL mesh. It is lit by its own lights and
    glowing surfaces, by a panorama (`sky`), or by lamps placed under its ceilings, and scaled to the
    scenario's illuminance. What things are is read from a table (`labels`), from properties of nodes, or
    from their names. The agent follows a recorded path, waypoints, or tours drawn over all of the floor it
    can reach.

    Names of settings are those of `scene.indoor` where they mean the same, so that a recipe changes from one
    to the other by two keys. One generator state gives one trip, always; the world is that of the file in
    each.

    >>> ImportedScene.Config(file="house.glb").sampling
    'walk'
    """

    carrier: ClassVar[str] = "person"
    one_world: ClassVar[bool] = True

    Config = ImportedSettings

    def __init__(self, config: ImportedSettings) -> None:
        from tacos_worlds.imported.present import faults_of_files

        self.config = config
        if faults := list(faults_of_files(config.file, config.labels, config.sky, config.path)):
            raise UserError(faults)
        self._place: Place | None = None

    @property
    def moves(self) -> str:
        from tacos_worlds.kit.carried import motion_words

        return motion_words(self.config, self.config.speed_m_s) if not self.config.path else ""

    @property
    def place(self) -> Place:
        """The file, read, labelled, lit and with its floor found; made once.

        Raises UserError with a fault for each thing that is wrong with the files.
        """
        if self._place is None:
            from tacos_worlds.imported.preparation import prepare  # late: it imports what builds worlds

            self._place = prepare(self.config)
        return self._place

    @property
    def remarks(self) -> tuple[str, ...]:
        """Doubts about the files, and what of them is not carried out, with its effect.

        Raises UserError with a fault for each thing that is wrong with the files.
        """
        from tacos_worlds.imported.preparation import survey

        return survey(self.config).remarks if self._place is None else self._place.world.remarks

    def episode(self, *, rng: np.random.Generator, illumination_lux: float) -> Episode:
        """A trip through the world.

        `illumination_lux`: mean illuminance on a plane 1 m above the floor that can be walked on [lux].
        """
        from tacos_worlds.imported.place import at_illuminance
        from tacos_worlds.imported.recorded import recorded_episode
        from tacos_worlds.kit.carried import carried
        from tacos_worlds.kit.walk.trip import joined

        if not illumination_lux > 0:
            raise ValueError(f"illumination_lux must be above 0, not {illumination_lux}")
        place = self.place
        wanted = illumination_lux if self.config.level == "scenario" else None
        world = at_illuminance(place.world, place.lux, wanted)
        if place.recorded is not None:
            trip = recorded_episode(rng, world, place, self.config.frames, self.config.frame_rate_hz)
        else:
            trip = joined(world, self._stretches(rng, place))
        (shaking_rng,) = rng.spawn(1)
        return carried(shaking_rng, trip, self.config)

    def _stretches(self, rng: np.random.Generator, place: Place) -> Iterator[Stretch]:
        from tacos_worlds.imported.walks import draw_walks
        from tacos_worlds.kit.walk.trip import along_walks, approaches

        config = self.config
        waypoints = padded(config.waypoints_m) - place.world.origin_m
        if config.sampling == "walk":
            walks = draw_walks(rng, place, waypoints, config.size_m, config.speed_m_s, config.camera_height_m)
            return along_walks(rng, walks, frames=config.frames, frame_rate_hz=config.frame_rate_hz)
        walks = draw_walks(rng, place, waypoints, config.size_m, config.speed_m_s, (0.0, 0.0))
        return approaches(
            rng,
            walks,
            frames=config.frames,
            before_s=config.before_step_s,
            camera_height_m=config.camera_height_m,
        )


def padded(points_m: tuple[tuple[float, ...], ...]) -> NDArray[np.float64]:
    """(N, 3) places, with NaN for a height that is not given [m]."""
    return np.array([(*point, np.nan)[:3] for point in points_m], np.float64).reshape(-1, 3)
