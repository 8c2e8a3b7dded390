"""Writes a results folder as a study would, with numbers of a plausible headset study."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np

SENSORS = [  # name, width_px, height_px, pixel_um
    ("IMX178", 3096, 2080, 2.4),
    ("IMX290", 1945, 1109, 2.9),
    ("IMX252", 2064, 1544, 3.45),
    ("IMX219", 3280, 2464, 1.12),
    ("AR0134", 1280, 960, 3.75),
    ("PYTHON1300", 1280, 1024, 4.8),
    ("IMX287", 728, 544, 6.9),
    ("IMX174", 1936, 1216, 5.86),
    ("IMX426", 816, 624, 9.0),
    ("IMX265", 2064, 1544, 3.45),
    ("IMX183", 5496, 3694, 2.4),
    ("IMX304", 4112, 3008, 3.45),
]
WEIGHTS = {"features.inliers": 0.0025, "features.inlier_ratio": 0.5, "obstacle.seen_ratio": 1.0}
OTHERS = {
    "oak_d_pro_wide": ("Luxonis OAK-D Pro Wide", ("IMX378", 4056, 3040, 1.55), 2.75, -20.0),
    "flea3": ("FLIR Flea3", ("IMX172", 4000, 3000, 1.55), 3.6, -23.3),
    "basler_dart": ("Basler dart daA1280-54uc", ("AR0134", 1280, 960, 3.75), 3.6, -25.9),
}
RECIPE = """tacos: 1
name: headset, quick
seed: 7
nodes:
  world: {use: scene.indoor, camera_height_m: [1.4, 1.8]}
"""


def sensor_row(sensor: tuple[str, int, int, float]) -> dict[str, Any]:
    """A catalog row as it stands in a camera."""
    name, width, height, pixel = sensor
    return {
        "name": name, "width_mm": width * pixel / 1e3, "height_mm": height * pixel / 1e3, "pixel_um": pixel,
    }  # fmt: skip


def camera(sensor: tuple[str, int, int, float], focal_length_mm: float, pitch_deg: float) -> dict[str, Any]:
    """A candidate's variables."""
    return {"pitch_deg": pitch_deg, "focal_length_mm": focal_length_mm, "sensor": sensor_row(sensor)}


def derived(sensor: tuple[str, int, int, float], focal_length_mm: float) -> dict[str, float]:
    """What follows from them."""
    row = sensor_row(sensor)
    return {
        "hfov_deg": math.degrees(2 * math.atan(row["width_mm"] / 2 / focal_length_mm)),
        "vfov_deg": math.degrees(2 * math.atan(row["height_mm"] / 2 / focal_length_mm)),
        "megapixels": sensor[1] * sensor[2] / 1e6,
    }


def scores_of(
    sensor: tuple[str, int, int, float], focal_length_mm: float, pitch_deg: float
) -> dict[str, float]:
    """Scores with one optimum, near a wide view of large pixels looking down."""
    view = derived(sensor, focal_length_mm)["hfov_deg"]
    wide = math.exp(-(((view - 105) / 45) ** 2))
    down = math.exp(-(((pitch_deg + 22) / 16) ** 2))
    light = 1 - math.exp(-sensor[3] / 2.2)
    return {
        "features.inliers": 260 * wide * light,
        "features.inlier_ratio": 0.16 * wide * light,
        "obstacle.seen_ratio": wide * down,
    }


def terms_of(scores: dict[str, float]) -> dict[str, float]:
    """Contribution of each score to the fitness."""
    return {score: weight * scores[score] for score, weight in WEIGHTS.items()}


def generations(rng: np.random.Generator, rounds: int = 12, size: int = 10) -> list[dict[str, Any]]:
    """A search that closes in on the optimum, with some candidates that fail."""
    lines, best = [], None
    for generation in range(rounds):
        candidates = []
        for index in range(size):
            spread = 1.0 if generation == 0 else 0.6**generation + 0.06
            sensor = SENSORS[int(rng.integers(len(SENSORS) if spread > 0.3 else 6))]
            ideal = sensor_row(sensor)["width_mm"] / 2 / math.tan(math.radians(52))
            focal = float(np.clip(ideal + rng.normal(0, 3.5 * spread), 1.0, 20.0))
            pitch = float(np.clip(-22 + rng.normal(0, 26 * spread), -30, 30))
            what, view = camera(sensor, focal, pitch), derived(sensor, focal)
            row: dict[str, Any] = {
                "key": f"{generation}-{index}", "camera": what, "derived": view,
                "fitness": None, "scores": {}, "terms": {}, "failed": None, "cached": False,
            }  # fmt: skip
            if view["hfov_deg"] > 140:
                row["failed"] = f"hfov_deg is {view['hfov_deg']:.1f}, above its maximum of 140"
            elif view["megapixels"] > 20:
                row["failed"] = f"megapixels is {view['megapixels']:.1f}, above its maximum of 20"
            else:
                row["scores"] = scores_of(sensor, focal, pitch)
                row["terms"] = terms_of(row["scores"])
                row["fitness"] = sum(row["terms"].values())
                if best is None or row["fitness"] > best["fitness"]:
                    best = {key: row[key] for key in ("camera", "derived", "fitness", "scores", "terms")}
            candidates.append(row)
        frames = 60 * sum(candidate["failed"] is None for candidate in candidates)
        lines.append(
            {
                "generation": generation,
                "seconds": 11.4,
                "frames": frames,
                "candidates": candidates,
                "best": best,
            }
        )
    return lines


def write_results(folder: Path, *, moments: int = 2) -> Path:
    """A complete folder: designed camera, three others, test, samples, recipe, log."""
    rng = np.random.default_rng(5)
    lines = generations(rng)
    best = lines[-1]["best"]
    named = {row["name"]: sensor for sensor in SENSORS for row in [sensor_row(sensor)]}
    sensor = named[best["camera"]["sensor"]["name"]]
    designed = (sensor, best["camera"]["focal_length_mm"], best["camera"]["pitch_deg"])
    designs = {"designed": ("Designed camera", designed)}
    designs |= {name: (title, (chip, f, pitch)) for name, (title, chip, f, pitch) in OTHERS.items()}
    cameras, test, samples = {}, {}, {}
    for name, (title, design) in designs.items():
        scores = {score: value * float(rng.normal(0.97, 0.01)) for score, value in scores_of(*design).items()}
        fitness = sum(terms_of(scores).values())
        episodes = [{k: v * w for k, v in {**scores, "fitness": fitness}.items()} for w in (0.97, 1.0, 1.03)]
        cameras[name] = {
            "title": title,
            "camera": camera(*design),
            "derived": derived(*design[:2]),
            "terms": terms_of(scores),
            "spread": {score: 0.03 * abs(value) for score, value in scores.items()}
            | {"fitness": 0.02 * fitness},
            "episodes": episodes,
            "evaluations": 120 if name == "designed" else 8,
            "free": ["sensor", "focal_length_mm", "pitch_deg"] if name == "designed" else ["pitch_deg"],
        }
        test[name] = {**scores, "fitness": fitness}
        samples[name] = []
        for moment in range(moments):
            path = folder / "samples" / f"{name}_{moment}.png"
            write_room(path, cameras[name]["derived"], design[2], moment, rng)
            samples[name].append(f"samples/{name}_{moment}.png")
    result = {
        "tacos": "0.1.0",
        "name": "headset, quick",
        "seed": 7,
        "stopped": "All 12 generations are done.",
        "evaluations": 120,
        "frames_rendered": sum(line["frames"] for line in lines),
        "seconds": 167.3,
        "best": best,
        "test": test,
        "cameras": cameras,
        "derived_units": {"hfov_deg": "deg", "vfov_deg": "deg", "megapixels": "MP"},
        "design_space": [
            {"name": "pitch_deg", "kind": "continuous", "unit": "deg", "lower": -30, "upper": 30},
            {"name": "focal_length_mm", "kind": "continuous", "unit": "mm", "lower": 1, "upper": 20},
            {"name": "sensor", "kind": "catalog", "unit": "", "values": 43, "scheme": "quantized"},
        ],
        "fitness": [{"score": score, "weight": weight} for score, weight in WEIGHTS.items()],
        "seconds_by_node": {
            "world": 9.1,
            "capture": 171.2,
            "frames": 14.9,
            "features": 88.0,
            "framework": 3.2,
        },
        "environment": {
            "python": "3.11.7",
            "platform": "Linux-6.1-x86_64",
            "cores": 2,
            "workers": 2,
            "gl_renderer": "llvmpipe (LLVM 15.0.6, 256 bits)",
            "packages": {"numpy": "2.4.6", "moderngl": "5.12.0"},
        },
        "notes": [
            "Every camera is simulated with an eighth of its pixels per side; noise is scaled to match."
        ],
        "samples": samples,
        "command": "tacos-run headset_quick --out runs/headset",
    }
    write_json(folder, result)
    (folder / "generations.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
    (folder / "recipe.yaml").write_text(RECIPE, "utf-8")
    (folder / "log.txt").write_text("10:00:00 study started\n10:02:47 study finished\n", "utf-8")
    return folder


def write_json(folder: Path, result: dict[str, Any]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "result.json").write_text(json.dumps(result), "utf-8")


def write_room(
    path: Path, view: dict[str, float], pitch_deg: float, moment: int, rng: np.random.Generator
) -> None:
    """A picture of a bare room (floor, walls, ceiling, ball), projected as that camera would see it."""
    width, focal = 400, 200 / math.tan(math.radians(view["hfov_deg"] / 2))
    height = round(2 * focal * math.tan(math.radians(view["vfov_deg"] / 2)))
    pitch = math.radians(pitch_deg)
    x, y = np.meshgrid((np.arange(width) - width / 2) / focal, (np.arange(height) - height / 2) / focal)
    ray = np.stack([np.cos(pitch) + y * np.sin(pitch), -x, np.sin(pitch) - y * np.cos(pitch)])
    with np.errstate(divide="ignore"):
        planes = np.stack(
            [
                np.where(ray[0] > 0, (6 - moment) / ray[0], np.inf),
                np.where(ray[1] > 0, 2.5, -3.5) / ray[1],
                np.where(ray[2] > 0, 1.4, -1.6) / ray[2],
            ]
        )
    nearest = planes.argmin(0)
    point = ray * planes.min(0)
    shade = np.select([nearest == 0, nearest == 1, point[2] > 0], [0.75, 0.6, 0.9], 0.42)
    tiles = (np.floor(point[0] * 2) + np.floor(point[1] * 2)) % 2
    shade = shade - 0.09 * tiles * (point[2] < -1.59)
    ball = ((point - np.array([4.0, 0.6 + moment, -1.3])[:, None, None]) ** 2).sum(0) < 0.25
    tint = np.where(ball, 0.4, 1.0)[..., None] ** np.array([2.0, 0.6, 0.1])
    image = np.clip(255 * shade[..., None] * tint + rng.normal(0, 5, (height, width, 3)), 0, 255)
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), image.astype(np.uint8))
