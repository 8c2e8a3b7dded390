"""The analysis a study may add to its results: a plausible one for the folder of `results_folder`."""

from __future__ import annotations

import math
from typing import Any

from tests.report.results_folder import OTHERS, SENSORS, camera, scores_of, terms_of

MARGIN = 0.012
INTERVALS = {
    "better": (0.031, 0.079),
    "worse": (-0.09, -0.02),
    "equivalent": (-0.008, 0.009),
    "undecided": (-0.02, 0.061),
}


def decided(result: dict[str, Any], verdict: str = "better") -> dict[str, Any]:
    """The keys ``decision`` and ``comparisons``, a product that breaks a constraint among them."""
    names = [name for name in result["cameras"] if name != "designed"]
    low, high = INTERVALS[verdict]
    first = {
        "against": names[0],
        "verdict": verdict,
        "difference": (low + high) / 2,
        "interval": [low, high],
        "episodes": 12,
    }
    others = [
        {"against": name, "verdict": "better", "difference": 0.2 * (place + 1),
         "interval": [0.2 * (place + 1) - 0.08, 0.2 * (place + 1) + 0.08], "episodes": 6}
        for place, name in enumerate(names[1:])
    ]  # fmt: skip
    why = "hfov_deg is 152, above its maximum of 140"
    left_out = {"against": "fisheye_190", "verdict": "not admissible", "why": why}
    decision = {
        **first,
        "margin": MARGIN,
        "margins": {"features.inliers": 2},
        "confidence": 0.95,
        "sentence": "said",
    }
    return {"decision": decision, "comparisons": [first, *others, left_out]}


def analysed(result: dict[str, Any], parts: int = 43) -> dict[str, Any]:
    """The keys ``ranking``, ``equivalent``, ``importance`` and ``front``."""
    rows = [_ranked(place, result) for place in range(parts)]
    rows.sort(key=lambda row: -row["fitness"])
    for row in rows[:4]:
        row.update(rescored=True, episodes=9, ci=[row["fitness"] - 0.01, row["fitness"] + 0.01])
    designed = result["cameras"]["designed"]["camera"]
    return {
        "ranking": rows,
        "ranking_left_out": [{"part": "LINE4K", "why": "megapixels is 31.2, above its maximum of 20"}],
        "equivalent": {
            "margin": MARGIN,
            "margins": {"features.inliers": 2},
            "parts": [row["part"] for row in rows[:7]],
            "probability": {row["part"]: 0.99 if place < 5 else 0.21 for place, row in enumerate(rows[:7])},
            "range": {
                "focal_length_mm": [1.9, 4.4],
                "pitch_deg": [-27.0, -9.5],
                "sensor": ["IMX178", "IMX252"],
            },
            "tolerance": {
                "focal_length_mm": [designed["focal_length_mm"] - 0.2, designed["focal_length_mm"] + 0.3],
                "pitch_deg": [designed["pitch_deg"] - 4.0, designed["pitch_deg"] + 3.0],
            },
        },
        "importance": [
            {"variable": "focal_length_mm", "unit": "mm", "first_order": 0.48, "total": 0.71,
             "curve": [_point(x, 3.0, 2.0) for x in range(1, 21)]},
            {"variable": "pitch_deg", "unit": "deg", "first_order": 0.2, "total": 0.31,
             "curve": [_point(x, -18.0, 14.0) for x in range(-30, 31, 4)]},
            {"variable": "sensor", "unit": "", "first_order": 0.04, "total": 0.12,
             "curve": [{**_point(i, 0.0, 30.0), "value": row["part"]} for i, row in enumerate(rows)]},
        ],
        "front": {
            "objectives": [
                {"name": "megapixels", "unit": "Mpx", "aim": "min"},
                {"name": "hfov_deg", "unit": "deg", "aim": "max"},
            ],
            "points": [
                {"camera": row["camera"], "part": row["part"], "fitness": row["fitness"], "ci": row["ci"],
                 "values": {"megapixels": 1.0 + i, "hfov_deg": 60.0 + 9 * i}, "rescored": i < 2}
                for i, row in enumerate(rows[:5])
            ],
        },
    }  # fmt: skip


def _ranked(place: int, result: dict[str, Any]) -> dict[str, Any]:
    sensor = SENSORS[place % len(SENSORS)]
    name = sensor[0] if place < len(SENSORS) else f"{sensor[0]}-{place}"
    focal = sensor[1] * sensor[3] / 2e3 / math.tan(math.radians(50))
    values = camera((name, *sensor[1:]), round(focal, 2), -20.0)
    fitness = sum(terms_of(scores_of(sensor, focal, -20.0)).values()) - 0.003 * place
    half = 0.02 + 0.004 * (place % 7)
    return {
        "part": name,
        "camera": values,
        "fitness": fitness,
        "ci": [fitness - half, fitness + half],
        "p_better": {product: 1 / (1 + math.exp(-(fitness - 1.3) / half)) for product in OTHERS},
        "rescored": False,
        "episodes": 0 if place % 3 else 2,
        "unknown": ["power_mw"] if place % 5 == 4 else [],
    }


def _point(x: float, best: float, width: float) -> dict[str, float]:
    mean = 1.5 * math.exp(-(((x - best) / width) ** 2))
    return {"value": float(x), "mean": mean, "low": mean - 0.08, "high": mean + 0.06}
