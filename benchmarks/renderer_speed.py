"""Frames per second of `renderer.moderngl` on a furnished indoor world, and whether its memory stays flat.

With `--against`, the processor time of this version and of another checkout, frame by frame in turns.

OMP_NUM_THREADS=1 python benchmarks/renderer_speed.py --size 640x480 --frames 100
OMP_NUM_THREADS=1 LP_NUM_THREADS=1 python benchmarks/renderer_speed.py --frames 100 --processes 2
OMP_NUM_THREADS=1 python benchmarks/renderer_speed.py --size 320x240 --frames 2000  # memory
OMP_NUM_THREADS=1 LP_NUM_THREADS=1 python benchmarks/renderer_speed.py --frames 12 --against OTHER_CHECKOUT
"""

from __future__ import annotations

import argparse
import logging
import multiprocessing
import time
from multiprocessing.synchronize import Barrier
from pathlib import Path

import numpy as np
from renderers.tour import SCENES, make_tour, parse_size
from renderers_in_turns import RendererProcess, cpu_times

from tacos_framework import Exposure, Rig
from tacos_plugins.renderers.moderngl.context import describe_gl
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer


def main() -> None:
    """Print the figures of one process or several."""
    arguments = parse_arguments()
    if arguments.against is not None:
        for scene in SCENES:
            measure_against(scene, arguments)
        return
    spawn = multiprocessing.get_context("spawn")  # a process with OpenGL must not fork
    start_together = spawn.Barrier(arguments.processes)
    others = [
        spawn.Process(target=measure, args=(arguments, start_together))
        for _ in range(arguments.processes - 1)
    ]
    for other in others:
        other.start()
    measure(arguments, start_together)
    for other in others:
        other.join()


def measure_against(scene: str, arguments: argparse.Namespace) -> None:
    """Draw a scene by both versions in turns."""
    tour = make_tour(scene, arguments.size, arguments.frames, arguments.seed)
    here = Path(__file__).parent.parent
    both = [RendererProcess("ours", tour, tree) for tree in (arguments.against, here)]
    cpu_s = cpu_times(both, [True, True], arguments.frames, arguments.rounds).mean(axis=1)
    differing = np.zeros(3)
    looked_at = range(0, arguments.frames, 3)
    for frame in looked_at:
        before, now = (process.picture(frame) for process in both)
        colour = np.abs(before.colour.astype(int) - now.colour).max(axis=2) > 5  # of 255: 2 % of white
        depth = ~np.isclose(before.depth_m, now.depth_m, rtol=1e-3)
        ids = before.object_id != now.object_id
        differing += [colour.mean(), depth.mean(), ids.mean()]
    print(f"{scene}: {tour.episode.world.triangle_count} triangles, {arguments.frames} frames")
    print(f"  {arguments.against}  {1e3 * cpu_s[0]:.1f} ms of processor time a frame")
    print(f"  {here}  {1e3 * cpu_s[1]:.1f} ms, {cpu_s[1] / cpu_s[0]:.2f} of it")
    print(
        "  pixels that differ: colour by 2 % {:.1e}, depth {:.1e}, ids {:.1e}".format(
            *differing / len(looked_at)
        )
    )
    for process in both:
        process.close()


def measure(arguments: argparse.Namespace, start_together: Barrier) -> None:
    """Prepare a world, wait for the other processes, and time frames."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    tour = make_tour("indoor", arguments.size, arguments.frames, arguments.seed)
    episode, frames = tour.episode, tour.frames
    rig, exposure = Rig((tour.camera,)), Exposure()
    renderer = ModernglRenderer(
        ModernglRenderer.Config(antialiasing=arguments.antialiasing, motion_samples=arguments.motion_samples)
    )

    start = time.perf_counter()
    renderer.capture(episode[:1], rig=rig, exposure=exposure)
    prepared_s = time.perf_counter() - start
    for frame in frames[:: max(len(frames) // 8, 1)]:  # compiles the shaders every room needs
        renderer.capture(episode[frame : frame + 1], rig=rig, exposure=exposure)

    start_together.wait()
    before = resident_bytes()
    start, start_cpu = time.perf_counter(), time.process_time()
    for frame in frames:
        renderer.capture(episode[frame : frame + 1], rig=rig, exposure=exposure)
    seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - start_cpu

    print(f"renderer          {describe_gl()}")
    print(f"world             {episode.world.triangle_count} triangles, {len(episode.world.lights)} lights")
    width_px, height_px = arguments.size
    print(f"images            {width_px} x {height_px}, {len(frames)} frames of colour, depth and ids")
    print(f"preparing         {prepared_s:.1f} s")
    print(f"speed             {len(frames) / seconds:.1f} frames/s")
    print(f"processor time    {1e3 * cpu_seconds / len(frames):.1f} ms per frame")
    print(f"memory            {before / 1e6:.0f} MB, grown by {(resident_bytes() - before) / 1e6:.1f} MB")


def parse_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--size", type=parse_size, default=(640, 480), help="image size, WIDTHxHEIGHT [px]")
    parser.add_argument("--frames", type=int, default=100, help="number of frames")
    parser.add_argument("--seed", type=int, default=1, help="seed of the world")
    parser.add_argument("--antialiasing", default="auto", help="auto, multisampling, edges or none")
    parser.add_argument("--motion-samples", type=int, default=1, help="poses per exposure")
    parser.add_argument("--processes", type=int, default=1, help="processes that render at the same time")
    parser.add_argument(
        "--against", type=checkout, help="another checkout, to be timed in turns with this one"
    )
    parser.add_argument("--rounds", type=int, default=3, help="with --against, times each frame is drawn")
    return parser.parse_args()


def checkout(text: str) -> Path:
    """The folder of a checkout; another would be passed over for what is installed."""
    if not Path(text, "plugins", "tacos_plugins").is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is not a checkout of this repository")
    return Path(text)


def resident_bytes() -> int:
    """Memory this process holds [bytes]; Linux only."""
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * 4096


if __name__ == "__main__":
    main()
