"""Processor time of a diagnosis, and of what it does over and over: simulate all captures and measure.

python benchmarks/diagnosis_speed.py --whole --effects vignetting defocus jpeg

Twelve captures in colour of a camera with one effect that the simulation lacks, taken on the bench of the
shipped recipe; one effect after the other. To set two versions side by side run it in turn with the
PYTHONPATH of each, on one folder (`--captures`).
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

from tacos_framework import Plugins, in_one_thread, load_recipe, run
from tacos_framework.formation import EpisodeDraws
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder, read_captures
from tacos_gap.captures.large import enough_pixels
from tacos_gap.hypotheses.candidates import candidates
from tacos_gap.simulation.formation import simulate
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
EFFECTS: dict[str, dict[str, Any]] = {
    "nothing": {},
    "vignetting": {"k1": -0.3},
    "lens-distortion": {"k1": -0.1},
    "lateral-chromatic-aberration": {"red": 0.0015, "blue": -0.001},
    "defocus": {"radius_px": 1.8},
    "prnu": {"sigma": 0.015},
    "dark-current": {"rate_dn_s": 20.0, "hot_share": 0.001},
    "read-noise": {"sigma_dn": 1.5},
    "row-noise": {"sigma_dn": 0.8},
    "tone-curve": {"gamma": 0.7},
    "denoise": {"strength": 0.5},
    "jpeg": {"quality": 80},
}
"""Effects to be found, with settings that are met in the field."""


def main() -> None:
    """Take the captures, measure them, and diagnose them if that is wanted."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--captures", type=Path, help="a folder of captures in place of those of the bench")
    parser.add_argument("--width", type=int, default=640, help="of the frames, three quarters as high [px]")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--whole", action="store_true", help="diagnose, too; minutes")
    parser.add_argument("--effects", nargs="+", choices=EFFECTS, default=["vignetting"], metavar="EFFECT")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        for effect in arguments.effects:
            if not arguments.captures:
                print(f"{effect}: ", end="", flush=True)
            folder = arguments.captures or taken(Path(temporary) / effect, arguments.width, effect)
            captures = read_captures(folder)
            in_one_thread(once)(captures, arguments.repeats)  # as in a diagnosis
            if arguments.whole:
                whole(captures, arguments.workers)


def taken(folder: Path, width: int, effect: str) -> Path:
    """The captures, taken by a camera with an effect."""
    sensor = {"width_px": width, "height_px": width * 3 // 4, "pixel_um": 3.0 * 640 / width}
    changed = {f"rig.sensor.{name}": value for name, value in sensor.items()}
    effects = [{"use": f"effect.{effect}", **EFFECTS[effect]}] if EFFECTS[effect] else []
    run(load_recipe("bench", {**changed, "captures": CAPTURES, "effects": effects}), out=folder)
    return folder


def once(folder: CaptureFolder, repeats: int) -> None:
    """Simulate every capture and measure it, the least of some repeats."""
    seconds = {"simulate": 0.0, "measure": 0.0}
    samples, enough = 0, enough_pixels(folder.captures)
    for capture in folder.captures:
        if capture.expected_dn is None:
            continue
        used = capture.of_at_most(enough)
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
    began_s = time.monotonic()
    found = diagnose(folder, effects, workers=workers)
    simulations = found.attribution.problem.simulations
    named = ", ".join(cause.effect for cause in found.causes) or "nothing"
    print(
        f"diagnosis: {time.monotonic() - began_s:.0f} s by the clock, {simulations} simulations of all "
        f"captures: {found.verdict}, {named}"
    )


if __name__ == "__main__":
    main()
