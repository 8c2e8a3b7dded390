"""What is photographed: the sets of captures a case may consist of."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tacos_validation.blind.generators import pictures
from tacos_validation.blind.generators.camera import Camera, Shot, dark
from tacos_validation.blind.generators.taking import moved

FRAME_INTERVAL_MS = 33.0


@dataclass(frozen=True, eq=False)
class Taking:
    """A capture to be taken.

    Parameters
    ----------
    id, kind
        Its name and kind in ``captures.yaml``.
    shots
        One, or one per frame of a sequence.
    frames
        Frames of the one shot; 1 for a sequence, whose shots have one each.
    group
        Captures that vary in exposure alone.
    chart, board
        What is shown, where the simulator describes it.
    """

    id: str
    kind: str
    shots: tuple[Shot, ...]
    frames: int = 4
    group: str | None = None
    chart: pictures.Chart | None = None
    board: pictures.Checkers | None = None


def new_camera(rng: np.random.Generator, width_px: int, height_px: int, channels: int) -> Camera:
    """A camera as the simulator believes it: noise, pedestal and field of view differ from case to case."""
    return Camera(
        width_px,
        height_px,
        focal_px=width_px * float(rng.uniform(0.95, 1.1)),
        channels=channels,
        black_dn=float(rng.integers(14, 21)),
        photon_dn=float(rng.uniform(0.12, 0.35)),
        thermal_dn2=float(rng.uniform(1.0, 2.5)),
    )


def charts(camera: Camera, rng: np.random.Generator) -> list[Taking]:
    """Dark stacks, flats, an exposure series, edges, boards, a chart, a scene and a sequence."""
    exposed = picture_series(camera, rng, (5.0, 10.0, 20.0))
    return [
        *darks(camera, (10.0, 200.0)),
        *flats(camera, rng, (0.15, 0.4, 0.72)),
        *exposed,
        edge(camera, rng),
        *boards(camera, rng, 3),
        chart(camera, rng),
        *scenes(camera, rng, 1),
        *sequences(camera, rng, 1),
    ]


def natural(camera: Camera, rng: np.random.Generator) -> list[Taking]:
    """Natural scenes alone, at several exposures, and one in motion."""
    return [*scenes(camera, rng, 4), *sequences(camera, rng, 1)]


def smallest(camera: Camera, rng: np.random.Generator) -> list[Taking]:
    """A dark, two flats and a scene: for tests."""
    return [*darks(camera, (10.0,)), *flats(camera, rng, (0.2, 0.6)), *scenes(camera, rng, 1)]


def darks(camera: Camera, times_ms: Sequence[float], frames: int = 4) -> Iterator[Taking]:
    """The cap on."""
    for i, time in enumerate(times_ms):
        yield Taking(f"dark_{i}", "dark", (Shot(camera, dark, time),), frames)


def flats(
    camera: Camera, rng: np.random.Generator, levels: Sequence[float], frames: int = 4
) -> Iterator[Taking]:
    """Even fields."""
    for i, level in enumerate(levels):
        look = pictures.even(camera, level * float(rng.uniform(0.9, 1.1)))
        yield Taking(f"flat_{i}", "flat", (Shot(camera, look, 10.0),), frames)


def picture_series(
    camera: Camera, rng: np.random.Generator, times_ms: Sequence[float], frames: int = 2
) -> Iterator[Taking]:
    """One scene at several exposure times; its lights are cut off at the longest."""
    base = pictures.natural(camera, rng, mean=0.6)
    for i, time in enumerate(times_ms):
        look = base.scaled(time / times_ms[-1])
        shot = Shot(camera, look, time, depth_m=1.5)
        yield Taking(f"bracket_{i}", "bracket", (shot,), frames, group="bracket")


def edge(camera: Camera, rng: np.random.Generator) -> Taking:
    """Straight edges all over the field."""
    return Taking("edge_0", "edge", (Shot(camera, pictures.edges(camera, rng), 10.0),), 4)


def boards(camera: Camera, rng: np.random.Generator, views: int, tilt_deg: float = 30.0) -> Iterator[Taking]:
    """Views of a chessboard."""
    for i in range(views):
        seen = pictures.board(camera, rng, tilt_deg)
        yield Taking(f"board_{i}", "board", (Shot(camera, seen, 10.0, has_pose=False),), 1, board=seen)


def chart(camera: Camera, rng: np.random.Generator) -> Taking:
    """A chart of patches."""
    shown = pictures.chart(camera, rng)
    return Taking("chart_0", "chart", (Shot(camera, shown.picture, 10.0),), 2, chart=shown)


def scenes(camera: Camera, rng: np.random.Generator, count: int, frames: int = 3) -> Iterator[Taking]:
    """Natural scenes at different distances and exposures."""
    for i in range(count):
        look = pictures.natural(camera, rng, mean=float(rng.uniform(0.25, 0.5)))
        shot = Shot(camera, look, (10.0, 20.0, 5.0, 40.0)[i % 4], depth_m=(2.0, 1.2, 4.0, 0.8)[i % 4])
        yield Taking(f"scene_{i}", "scene", (shot,), frames)


def sequences(camera: Camera, rng: np.random.Generator, count: int, frames: int = 3) -> Iterator[Taking]:
    """Scenes that pass by."""
    for i in range(count):
        look = pictures.natural(camera, rng)
        speed, angle = float(rng.uniform(250, 450)), float(rng.uniform(0, 2 * np.pi))
        velocity = (speed * np.cos(angle), 0.5 * speed * np.sin(angle))
        first = Shot(camera, look, 10.0, velocity_px_s=velocity, depth_m=2.0)
        # scenes stay within their canvas: they move to and fro about the middle frame
        times = [(k - (frames - 1) / 2) * FRAME_INTERVAL_MS * 1e-3 for k in range(frames)]
        shots = tuple(replace(moved(first, time), velocity_px_s=velocity) for time in times)
        yield Taking(f"sequence_{i}", "sequence", shots, 1)


SETS: Mapping[str, Callable[[Camera, np.random.Generator], list[Taking]]] = {
    "charts": charts,
    "natural": natural,
    "smallest": smallest,
}
"""Sets of captures by name."""
