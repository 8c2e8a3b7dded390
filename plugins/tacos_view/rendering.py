"""Frames in memory: images with depth, ids and poses, which show themselves in notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, FrameBatch, Plugins, Recipe, Trajectory, World
from tacos_framework.camera import Exposed, exposed
from tacos_view.cameras import CameraName
from tacos_view.pictures import contact_sheet, encoded_png, png_uri, shown_depth, shown_frame
from tacos_view.setup import set_up

MOST_SHOWN = 12
"""Frames side by side in a notebook: more would be too small to see anything in."""


@dataclass(frozen=True, eq=False)
class CameraFrames:
    """Images and truth of one camera. Row 0 of every array is the top of the image."""

    camera: Camera
    """The camera; its `intrinsics` are those of these images."""
    image: NDArray[np.unsignedinteger]
    """(N, H, W, C) uint8 or uint16; unless `coded` proportional to light above `black_level_dn` [DN]."""
    depth_m: NDArray[np.float32]
    """(N, H, W) float32 distance along the optical axis, infinite where nothing is [m]."""
    object_id: NDArray[np.int32]
    """(N, H, W) int32 index into `World.objects`; 0 is the background."""
    world_from_camera: NDArray[np.float64]
    """(N, 4, 4) float64 poses in the middle of the exposure; x right, y down, z forward [m]."""
    luminance_cd_m2: NDArray[np.float32]
    """(N, H, W, 3) float32 light before the sensor [cd/m2]."""

    def __repr__(self) -> str:
        camera = self.camera
        return f"<{camera.name}: {len(self)} frames of {camera.width_px} x {camera.height_px} pixels>"

    def __len__(self) -> int:
        return len(self.image)


@dataclass(frozen=True, eq=False)
class Rendering:
    """Frames of a rig in a world; arrays of the first camera are its own attributes."""

    title: str
    """Which camera it is."""
    cameras: Mapping[str, CameraFrames]
    """What each camera took, by name, in the rig's order."""
    time_s: NDArray[np.float64]
    """(N,) middle of each exposure [s]."""
    walk: NDArray[np.int32]
    """(N,) int32: frames with equal numbers follow each other continuously."""
    world: World
    """What was looked at: its parts, lights, objects and class names."""
    trajectory: Trajectory
    black_level_dn: float
    white_level_dn: float
    """Pedestal and full scale of the images [DN]."""
    coded: bool = False
    """True if they are coded for a display, rather than linear."""

    @property
    def first(self) -> CameraFrames:
        return next(iter(self.cameras.values()))

    @property
    def camera(self) -> Camera:
        return self.first.camera

    @property
    def image(self) -> NDArray[np.unsignedinteger]:
        """Images of the first camera; see `CameraFrames`."""
        return self.first.image

    @property
    def depth_m(self) -> NDArray[np.float32]:
        """Depth in the first camera; see `CameraFrames`."""
        return self.first.depth_m

    @property
    def object_id(self) -> NDArray[np.int32]:
        """Object ids in the first camera; see `CameraFrames`."""
        return self.first.object_id

    @property
    def class_id(self) -> NDArray[np.int32]:
        """(N, H, W) index into `World.class_names`, in the first camera."""
        classes: NDArray[np.int32] = self.world.class_of_object[self.first.object_id]
        return classes

    @property
    def world_from_camera(self) -> NDArray[np.float64]:
        """Poses of the first camera; see `CameraFrames`."""
        return self.first.world_from_camera

    def exposed(self, camera: str) -> Exposed:
        """Exposure of the frames of a camera."""
        return exposed(self.cameras[camera].image, self.black_level_dn, self.white_level_dn)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Advice where frames are over- or underexposed, in a sentence for each camera."""
        found = ((name, self.exposed(name).doubt) for name in self.cameras)
        return tuple(f"{name}: {doubt}" for name, doubt in found if doubt)

    def __len__(self) -> int:
        return len(self.time_s)

    def __getitem__(self, camera: str) -> CameraFrames:
        return self.cameras[camera]

    def displayed(self) -> list[NDArray[np.uint8]]:
        """The frames of the first camera as people expect to see them, (H, W, 3) sRGB each."""
        levels = self.black_level_dn, self.white_level_dn
        return [shown_frame(image, *levels, coded=self.coded) for image in self.image]

    def __repr__(self) -> str:
        """One line: the arrays and the world would fill the terminal."""
        return f"<{self._said}; cameras {', '.join(self.cameras)}>"

    @property
    def _said(self) -> str:
        camera = self.camera
        return (
            f"{self.title}: {len(self)} frames of {camera.width_px} x {camera.height_px} pixels, "
            f"{camera.hfov_deg:.0f} x {camera.vfov_deg:.0f} deg"
        )

    def _repr_png_(self) -> bytes:
        """In a notebook: frames of every camera above their depth, reduced; of many some from all over."""
        return encoded_png(self._sheet())

    def _repr_html_(self) -> str:
        some = f"; {MOST_SHOWN} of them" if len(self) > MOST_SHOWN else ""
        caption = f"<figcaption>{self._said}{some}</figcaption>"
        return f'<figure><img style="max-width: 100%" src="{png_uri(self._sheet())}">{caption}</figure>'

    def _sheet(self) -> NDArray[np.uint8]:
        shown = np.linspace(0, len(self) - 1, min(len(self), MOST_SHOWN)).round().astype(int)
        levels = self.black_level_dn, self.white_level_dn
        tiles = []
        for taken in self.cameras.values():
            tiles += [shown_frame(taken.image[i], *levels, coded=self.coded) for i in shown]
            tiles += [shown_depth(taken.depth_m[i]) for i in shown]
        return contact_sheet(tiles, columns=len(shown))


def render(
    recipe: str | Path | Recipe,
    camera: CameraName = None,
    *,
    frames: int = 1,
    seed: int | None = None,
    spread: bool = False,
    sets: Mapping[str, Any] | None = None,
    effects: Sequence[Mapping[str, Any]] = (),
    plugins: Plugins | None = None,
) -> Rendering:
    """Frames of a camera in the scene of a recipe, noise and effects included.

    - `recipe`: path or name of a recipe, a recipe, the results folder of a study, or a scene:
      ``"scene.indoor"``.
    - `camera`: name of a product, or of a camera of the run; values such as ``{"focal_length_mm": 4,
      "sensor": "IMX296"}``; or None: the designed camera of a run, else the first product the recipe compares
      with.
    - `seed`: which world and trip; the recipe's seed if None.
    - `spread`: take them from all over the trip, rather than one after the other.
    - `sets`: dotted keys of the recipe and the values to put there, as in ``{"rig.binning": 8}``.
    - `effects`: effects to add, as in ``[{"use": "effect.vignetting", "k1": -0.4}]``.
    - `plugins`: what is installed; it is looked up if None.

    Raises `UserError` with all that is wrong with the recipe, or with the camera.
    """
    setup = set_up(recipe, camera, sets=sets, effects=effects, plugins=plugins)
    taken = setup.along_the_trip(frames, seed=seed) if spread else setup.frames(frames, seed=seed)
    return collected(taken, setup.camera.title)


def collected(batches: Iterable[FrameBatch], title: str) -> Rendering:
    """Batches of one episode as one rendering."""
    kept = list(batches)
    first = kept[0]
    cameras = {
        view.camera.name: CameraFrames(
            camera=view.camera,
            image=np.concatenate([batch.images[i] for batch in kept]),
            **{name: _joined(kept, i, name) for name in _ARRAYS},
        )
        for i, view in enumerate(first.capture.views)
    }
    return Rendering(
        title=title,
        cameras=cameras,
        time_s=np.concatenate([batch.episode.time_s for batch in kept]),
        walk=np.concatenate([batch.episode.walk for batch in kept]),
        world=first.episode.world,
        trajectory=first.episode.trajectory,
        black_level_dn=first.black_level_dn,
        white_level_dn=first.white_level_dn,
        coded=first.coded,
    )


_ARRAYS = ("depth_m", "object_id", "world_from_camera", "luminance_cd_m2")


def _joined(batches: Sequence[FrameBatch], camera: int, name: str) -> NDArray[Any]:
    return np.concatenate([getattr(batch.capture.views[camera], name) for batch in batches])
