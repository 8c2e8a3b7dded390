"""Sets of captures that a case may consist of."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tacos_validation.blind.generators import flat_scenes
from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, dark
from tacos_validation.blind.generators.image_formation import moved

FRAME_INTERVAL_MS = 33.0
HIGH_GAIN_DB = 12.0


@dataclass(frozen=True, eq=False)
class Acquisition:
    id: str
    kind: str
    shots: tuple[IdealShot, ...]  # one, or one per frame of a sequence
    frames: int = 4  # frames of the one shot; 1 for a sequence, whose shots have one each
    group: str | None = None  # captures that vary in exposure alone
    chart: flat_scenes.Chart | None = None
    board: flat_scenes.Checkers | None = None


def new_camera(rng: np.random.Generator, width_px: int, height_px: int, channels: int) -> IdealCamera:
    """A camera as the simulator believes it: noise, pedestal and field of view differ from case to case."""
    return IdealCamera(
        width_px,
        height_px,
        focal_px=width_px * float(rng.uniform(0.95, 1.1)),
        channels=channels,
        black_dn=float(rng.integers(14, 21)),
        photon_dn=float(rng.uniform(0.12, 0.35)),
        thermal_dn2=float(rng.uniform(1.0, 2.5)),
    )


def charts(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
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


def natural(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
    """Natural scenes alone, at several exposures, and one in motion."""
    return [*scenes(camera, rng, 4), *sequences(camera, rng, 1)]


def smallest(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
    """A dark, two flats and a scene: for tests."""
    return [*darks(camera, (10.0,)), *flats(camera, rng, (0.2, 0.6)), *scenes(camera, rng, 1)]


def two_gains(camera: IdealCamera, rng: np.random.Generator) -> list[Acquisition]:
    """Caps and walls at 0 dB and at `HIGH_GAIN_DB`, and a scene."""
    walls = (0.15, 0.5)
    high = [*darks(camera, (10.0,)), *flats(camera, rng, walls)]
    low = [*darks(camera, (10.0,)), *flats(camera, rng, walls), *scenes(camera, rng, 1)]
    return [*low, *(_at_gain(each, HIGH_GAIN_DB) for each in high)]


def _at_gain(taken: Acquisition, gain_db: float) -> Acquisition:
    shots = tuple(replace(shot, gain_db=gain_db) for shot in taken.shots)
    return replace(taken, id=f"{taken.id}_{gain_db:g}db", shots=shots)


def darks(camera: IdealCamera, times_ms: Sequence[float], frames: int = 4) -> Iterator[Acquisition]:
    for i, time in enumerate(times_ms):
        yield Acquisition(f"dark_{i}", "dark", (IdealShot(camera, dark, time),), frames)


def flats(
    camera: IdealCamera, rng: np.random.Generator, levels: Sequence[float], frames: int = 4
) -> Iterator[Acquisition]:
    for i, level in enumerate(levels):
        look = flat_scenes.even(camera, level * float(rng.uniform(0.9, 1.1)))
        yield Acquisition(f"flat_{i}", "flat", (IdealShot(camera, look, 10.0),), frames)


def picture_series(
    camera: IdealCamera, rng: np.random.Generator, times_ms: Sequence[float], frames: int = 2
) -> Iterator[Acquisition]:
    """One scene at several exposure times; its lights are cut off at the longest."""
    base = flat_scenes.natural(camera, rng, mean=0.6)
    for i, time in enumerate(times_ms):
        look = base.scaled(time / times_ms[-1])
        shot = IdealShot(camera, look, time, depth_m=1.5)
        yield Acquisition(f"bracket_{i}", "bracket", (shot,), frames, group="bracket")


def edge(camera: IdealCamera, rng: np.random.Generator) -> Acquisition:
    return Acquisition("edge_0", "edge", (IdealShot(camera, flat_scenes.edges(camera, rng), 10.0),), 4)


def boards(
    camera: IdealCamera, rng: np.random.Generator, views: int, tilt_deg: float = 30.0
) -> Iterator[Acquisition]:
    for i in range(views):
        seen = flat_scenes.board(camera, rng, tilt_deg)
        yield Acquisition(
            f"board_{i}", "board", (IdealShot(camera, seen, 10.0, has_pose=False),), 1, board=seen
        )


def chart(camera: IdealCamera, rng: np.random.Generator) -> Acquisition:
    shown = flat_scenes.chart(camera, rng)
    return Acquisition("chart_0", "chart", (IdealShot(camera, shown.picture, 10.0),), 2, chart=shown)


def scenes(
    camera: IdealCamera, rng: np.random.Generator, count: int, frames: int = 3
) -> Iterator[Acquisition]:
    for i in range(count):
        look = flat_scenes.natural(camera, rng, mean=float(rng.uniform(0.25, 0.5)))
        shot = IdealShot(camera, look, (10.0, 20.0, 5.0, 40.0)[i % 4], depth_m=(2.0, 1.2, 4.0, 0.8)[i % 4])
        yield Acquisition(f"scene_{i}", "scene", (shot,), frames)


def sequences(
    camera: IdealCamera, rng: np.random.Generator, count: int, frames: int = 3
) -> Iterator[Acquisition]:
    for i in range(count):
        look = flat_scenes.natural(camera, rng)
        speed, angle = float(rng.uniform(250, 450)), float(rng.uniform(0, 2 * np.pi))
        velocity = (speed * np.cos(angle), 0.5 * speed * np.sin(angle))
        first = IdealShot(camera, look, 10.0, velocity_px_s=velocity, depth_m=2.0)
        # scenes stay within their canvas: they move to and fro about the middle frame
        times = [(k - (frames - 1) / 2) * FRAME_INTERVAL_MS * 1e-3 for k in range(frames)]
        shots = tuple(replace(moved(first, time), velocity_px_s=velocity) for time in times)
        yield Acquisition(f"sequence_{i}", "sequence", shots, 1)


SETS: Mapping[str, Callable[[IdealCamera, np.random.Generator], list[Acquisition]]] = {
    "charts": charts,
    "natural": natural,
    "smallest": smallest,
    "two_gains": two_gains,
}
"""Sets of captures by name."""
