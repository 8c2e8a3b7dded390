"""Processor time of `renderer.moderngl` and of renderers an engineer might pick instead, in turns in one run.

pip install tacos-framework[bench]
OMP_NUM_THREADS=1 LP_NUM_THREADS=1 python benchmarks/renderer_compared.py --figures .

All draw the same meshes from the same poses through EGL and read the frames back, each in a process of its
own, frame by frame in turns. Whether they show the same view is checked by depth and ids of one frame, and
may be seen in the figures; where depth is that of one of four samples rather than of the pixel's centre, it
differs at edges. What each leaves out stands beside its time.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
from renderers import NAMES, Picture
from renderers.tour import SCENES, make_tour, parse_size
from renderers_in_turns import RendererProcess, cpu_times

_UNLIT = "light, bump, sky"
_PER_VERTEX = "shadows, indirect light, reflections, bump, sky, light between vertices"
_LIT = "shadows, indirect light, all lamps but four, reflected surroundings, bump, sky"
LEFT_OUT = {
    "ours": "",
    "per-vertex": f"{_PER_VERTEX}, antialiasing, more than 8 bits",
    "per-vertex, 4 samples": f"{_PER_VERTEX}, more than 8 bits",
    "panda3d": f"{_UNLIT}, antialiasing, more than 8 bits",
    "panda3d, 4 samples": f"{_UNLIT}, more than 8 bits",
    "pyrender unlit": f"{_UNLIT}, more than 8 bits",
    "pyrender lit": f"{_LIT}, more than 8 bits",
}
WAYS = [("ours", True)] + [(name, ids) for name in NAMES[1:] for ids in (False, True)]


def main() -> None:
    """Print a table per scene, and write its figure."""
    arguments = parse_arguments()
    if missing := [name for name in ("pyrender", "panda3d") if find_spec(name) is None]:
        raise SystemExit(f"no {' and no '.join(missing)}: pip install tacos-framework[bench]")
    for scene in arguments.scenes:
        compare(scene, arguments)


def compare(scene: str, arguments: argparse.Namespace) -> None:
    """One scene by all renderers."""
    tour = make_tour(scene, arguments.size, arguments.frames, arguments.seed)
    processes = {name: RendererProcess(name, tour) for name in NAMES}
    ways = [way for way in WAYS if way[0] in processes]
    seconds = cpu_times(
        [processes[name] for name, _ in ways], [ids for _, ids in ways], arguments.frames, arguments.rounds
    ).mean(axis=1)

    middle = arguments.frames // 2
    pictures = {name: process.picture(middle) for name, process in processes.items()}
    world = tour.episode.world
    print(f"\n{scene}: {world.triangle_count} triangles, {len(world.materials)} materials; ", end="")
    print("{} x {}, {} frames".format(*arguments.size, arguments.frames))
    print("| | CPU a frame | over ours | same depth | same ids | leaves out |")
    print("| --- | --- | --- | --- | --- | --- |")
    for (name, ids), each in zip(ways, seconds, strict=True):
        depth, labels = agreement(pictures["ours"], pictures[name])
        what = f"{name}: colour, depth{', ids' if ids else ''}"
        same_ids = f"{labels:.2%}" if ids else ""
        figures = f"{1e3 * each:.1f} ms | {each / seconds[0]:.2f} | {depth:.2%} | {same_ids}"
        print(f"| {what} | {figures} | {LEFT_OUT[name]} |")
    if arguments.figures is not None:
        write_figure(arguments.figures / f"renderers_{scene}.png", pictures)
    for process in processes.values():
        process.close()


def agreement(ours: Picture, theirs: Picture) -> tuple[float, float]:
    """Shares of pixels whose depth is within 1 % of ours, and whose ids are ours [1]."""
    seen = np.isfinite(ours.depth_m)
    ratio = theirs.depth_m[seen] / ours.depth_m[seen]
    return float((np.abs(ratio - 1) < 0.01).mean()), float((ours.object_id == theirs.object_id)[seen].mean())


def write_figure(path: Path, pictures: dict[str, Picture]) -> None:
    """All pictures side by side, their names in them."""
    tiles = [_named(name, picture) for name, picture in pictures.items()]
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % 4)
    rows: Sequence[np.ndarray] = [np.hstack(tiles[first : first + 4]) for first in range(0, len(tiles), 4)]
    cv2.imwrite(str(path), np.vstack(rows))


def _named(name: str, picture: Picture) -> np.ndarray:
    tile = np.ascontiguousarray(picture.colour[..., ::-1])
    cv2.rectangle(tile, (0, 0), (9 + 11 * len(name), 26), (255, 255, 255), cv2.FILLED)
    return cv2.putText(tile, name, (5, 19), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 1, cv2.LINE_AA)


def parse_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--size", type=parse_size, default=(640, 480), help="image size, WIDTHxHEIGHT [px]")
    parser.add_argument("--frames", type=int, default=12, help="number of frames")
    parser.add_argument("--rounds", type=int, default=3, help="times each frame is drawn; the least counts")
    parser.add_argument("--seed", type=int, default=1, help="seed of the world")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES), help="what is drawn")
    parser.add_argument("--figures", type=Path, help="folder for the pictures side by side")
    return parser.parse_args()


if __name__ == "__main__":
    main()
