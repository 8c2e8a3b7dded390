"""Time, time to the first answer and peak memory of a diagnosis as an owner asks for it, on two cores.

python benchmarks/diagnosis_of_folders.py phone small large

Each folder is made here, imported and diagnosed in a process of its own: *phone*, 20 pictures of 480 x 360 in
colour, boards among them; *small*, 12 captures of 640 x 480 of the bench; *large*, 9 of 12 megapixels.
"""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from diagnosis_speed import taken
from numpy.typing import NDArray

from tacos_framework import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import SoFar
from tacos_gap.captures import read_captures
from tacos_gap.hypotheses.candidates import candidates
from tacos_gap.photographs.given import Given
from tacos_gap.photographs.importing import import_photographs

GOALS = {"phone": (60, 20), "small": (40, 12), "large": (90, 9)}
"""Seconds by the clock with two idle cores, and pictures or captures."""

FIRST_ANSWER_S = 10
FULL_WELL_E, READ_NOISE_E, PEDESTAL_DN = 6000.0, 6.0, 8.0
POSES = [(0.0, 0.0), (0.5, 0.0), (-0.5, 0.1), (0.0, 0.6), (0.0, -0.6), (0.4, 0.4), (0.3, -0.4)]
"""Turns of the board about the image's axes [rad]."""


def main() -> None:
    """Measure each of the folders that are named."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", nargs="+", choices=GOALS, metavar="FOLDER")
    context = multiprocessing.get_context("spawn")
    for name in parser.parse_args().folders:
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary) / "captures"
            if name == "small":
                taken(folder, 640, "vignetting")
            else:
                photograph(Path(temporary) / "photos", 480 if name == "phone" else 4000)
            process = context.Process(target=measured, args=(name, folder))
            process.start()
            process.join()


def measured(name: str, folder: Path) -> None:
    """Import and diagnose in this process, which did nothing before, and print what it took."""
    first: list[float] = []

    def keep(found: SoFar) -> None:
        first.append(time.monotonic())

    began_s = time.monotonic()
    if name != "small":
        import_photographs([folder.with_name("photos")], folder, Given())
    imported_s = time.monotonic()
    found = diagnose(read_captures(folder), candidates(Plugins.discover()), workers=2, keep=keep)
    goal_s, count = GOALS[name]
    ended_s = time.monotonic()
    named = ", ".join(cause.effect for cause in found.causes) or "nothing"
    print(f"{name}, {count} pictures: {found.verdict}, {named}")
    del found  # ends the process beside this one, whose memory is known then
    gc.collect()
    beside_gib = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 2**20
    print(
        f"  {ended_s - began_s:.0f} s, goal {goal_s}; import {imported_s - began_s:.1f} s, first answer "
        f"{first[0] - imported_s:.1f} s after it, goal {FIRST_ANSWER_S}; "
        f"{_peak_gib() + beside_gib:.1f} GiB at most",
        flush=True,
    )


def _peak_gib() -> float:
    """Peak memory of this process; `ru_maxrss` would be that of the one that started it, if larger."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 2**20 for line in lines if line.startswith("VmHWM"))


def photograph(folder: Path, width: int) -> None:
    """Three caps, walls at three levels, edges and boards: the last only of small pictures."""
    folder.mkdir()
    rng = np.random.default_rng(3)
    height = width * 3 // 4
    y, x = np.mgrid[:height, :width]
    radius2 = ((x - width / 2) ** 2 + (y - height / 2) ** 2) / ((width / 2) ** 2 + (height / 2) ** 2)
    response = 1 + rng.normal(0, 0.008, (height, width, 3))
    for number, light in enumerate(_scenes(x, y, width, height, has_boards=width < 1000)):
        blurred = cv2.GaussianBlur(light, (0, 0), 1.3) * (1 - 0.35 * radius2)
        electrons = blurred[..., None] * np.array([0.9, 1.0, 0.7]) * response * FULL_WELL_E
        noisy = rng.poisson(electrons) + rng.normal(0, READ_NOISE_E, electrons.shape)
        codes = np.rint(noisy * 255 / FULL_WELL_E + PEDESTAL_DN)
        cv2.imwrite(str(folder / f"IMG_{number:04d}.png"), np.clip(codes, 0, 255).astype(np.uint8)[..., ::-1])


def _scenes(
    x: NDArray[Any], y: NDArray[Any], width: int, height: int, *, has_boards: bool
) -> Iterator[NDArray[np.float64]]:
    """(H, W) light of each picture, 1 at full scale."""
    dark = np.zeros((height, width))
    yield from [dark] * 3
    for level in (0.2, 0.45, 0.75):
        yield from [dark + level] * (2 if has_boards else 1)
    for offset in (0, width // 4):
        slope = np.cos(0.1) * (x - width / 2 - offset) + np.sin(0.1) * (y - height / 2)
        yield from [0.1 + 0.6 * np.clip(slope + 0.5, 0, 1)] * (2 if has_boards else 1)
    if has_boards:
        yield from (_board(turn, width, height) for turn in POSES)
    else:
        yield dark + 0.45


def _board(turn: tuple[float, float], width: int, height: int) -> NDArray[np.float64]:
    """A board of 9 x 6 inner corners and squares of 25 mm seen by a barrel, ray by ray."""
    camera = np.array([[0.875 * width, 0, width / 2], [0, 0.875 * width, height / 2], [0, 0, 1.0]])
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).reshape(-1, 1, 2)
    rays = cv2.undistortPoints(pixels.astype(np.float64), camera, np.array([-0.22, 0.05, 0, 0]))[:, 0]
    rays = np.column_stack([rays, np.ones(len(rays))])
    rotation, _ = cv2.Rodrigues(np.array([*turn, 0.0]))
    place = np.array([0.0, 0.0, 340.0])
    reach = (rotation[:, 2] @ place) / (rays @ rotation[:, 2])
    across, down = ((rays * reach[:, None] - place) @ rotation)[:, :2].T / 25 + np.array([[5.0], [3.5]])
    inside = (across > 0) & (across < 10) & (down > 0) & (down < 7)
    white = (np.floor(across) + np.floor(down)) % 2 == 1
    paper = (across > -1) & (across < 11) & (down > -1) & (down < 8)
    light = np.where(inside, np.where(white, 0.7, 0.05), np.where(paper, 0.7, 0.3))
    return np.asarray(light.reshape(height, width))


if __name__ == "__main__":
    main()
