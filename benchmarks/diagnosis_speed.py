"""Processor time of a diagnosis, and of what it does over and over: simulate all captures and measure.

OMP_NUM_THREADS=1 python benchmarks/diagnosis_speed.py --width 640 --whole

Twelve captures in colour of a camera with vignetting, taken on the bench of the shipped recipe. To set two
versions side by side run it in turn with the PYTHONPATH of each, on one folder (`--captures`).
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from tacos_framework import load_recipe, run
from tacos_framework.formation import EpisodeDraws
from tacos_framework.plugins import Plugins
from tacos_gap.candidates import candidates
from tacos_gap.captures import CaptureFolder, read_captures
from tacos_gap.diagnosis import ENOUGH_PIXELS, diagnose
from tacos_gap.formation import simulate
from tacos_gap.statistics import Sample, measure

LIGHT_BOX = {"use": "scene.light-box"}
CAPTURES = [
    {"id": "dark", "kind": "dark", "exposure_ms": [10, 400]},
    {"id": "flat", "kind": "flat", "scene": LIGHT_BOX, "level": [0.1, 0.3, 0.6, 0.9]},
    {
        "id": "bracket",
        "kind": "bracket",
        "scene": LIGHT_BOX,
        "exposure_ms": [5, 20, 40],
        "level": 1.2,
        "frames": 2,
    },
    {"id": "bars", "kind": "scene", "scene": {"use": "scene.grey-bars", "width_m": 0.26, "height_m": 0.2}},
    {"id": "edges", "kind": "edge", "scene": {"use": "scene.slanted-edges", "angle_deg": 5}},
    {"id": "texture", "kind": "scene", "scene": {"use": "scene.textured-target", "size_m": 0.3}},
]


def main() -> None:
    """Take the captures, measure them, and diagnose them if that is wanted."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--captures", type=Path, help="a folder of captures in place of those of the bench")
    parser.add_argument("--width", type=int, default=640, help="of the frames, three quarters as high [px]")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--whole", action="store_true", help="diagnose, too; minutes")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.captures or taken(Path(temporary) / "captures", arguments.width)
        captures = read_captures(folder)
        once(captures, arguments.repeats)
        if arguments.whole:
            whole(captures, arguments.workers)


def taken(folder: Path, width: int) -> Path:
    """The captures, taken."""
    sensor = {"width_px": width, "height_px": width * 3 // 4, "pixel_um": 3.0 * 640 / width}
    changed = {f"rig.sensor.{name}": value for name, value in sensor.items()}
    effects = [{"use": "effect.vignetting", "k1": -0.3}]
    run(load_recipe("bench", {**changed, "captures": CAPTURES, "effects": effects}), out=folder)
    return folder


def once(folder: CaptureFolder, repeats: int) -> None:
    """Simulate every capture and measure it, the least of some repeats."""
    seconds = {"simulate": 0.0, "measure": 0.0}
    samples = 0
    for capture in folder.captures:
        if capture.expected_dn is None:
            continue
        used = capture.of_at_most(ENOUGH_PIXELS)
        samples += used.real_dn.size
        found: dict[str, list[float]] = {name: [] for name in seconds}
        for draw in range(repeats + 1):  # the first fills what is kept per capture
            began = time.process_time()
            frames = simulate(used, (), EpisodeDraws(0, ("benchmark", draw)))
            between = time.process_time()
            measure(Sample(used, frames, used.expected_dn))  # type: ignore[arg-type]
            found["simulate"].append(between - began)
            found["measure"].append(time.process_time() - between)
        for name in seconds:
            seconds[name] += min(found[name][1:])
    told = ", ".join(f"{name} {value:.2f} s" for name, value in seconds.items())
    print(f"{len(folder.captures)} captures, {samples / 1e6:.0f} million samples once: {told}")


def whole(folder: CaptureFolder, workers: int) -> None:
    """Diagnose the captures."""
    effects = candidates(Plugins.discover())
    began, clock = time.process_time(), time.monotonic()
    found = diagnose(folder, effects, workers=workers)
    named = ", ".join(cause.effect for cause in found.causes) or "nothing"
    print(
        f"diagnosis: {time.process_time() - began:.0f} s of processor time, {time.monotonic() - clock:.0f} s "
        f"by the clock, {found.attribution.problem.evaluations} hypotheses simulated: "
        f"{found.verdict}, {named}"
    )


if __name__ == "__main__":
    main()
