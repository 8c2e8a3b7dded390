"""A headset's camera to design, in closed form: the shape of the real problem without its images.

Inliers grow with pixels, need a field that frames share, and fall where pixels are small for the light;
thresholds are seen by cameras that look down and wide enough. Scenes differ, and scores are counts of few.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tacos_framework.catalog import find_catalog
from tacos_framework.contracts import Asked, DesignProblem, Evaluated
from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.variables.design_space import Candidate, CatalogChoice, Continuous, DesignSpace
from tacos_plugins.rigs.monocular import MonocularRig

FITNESS = Fitness(
    (FitnessTerm("orb.inliers", 0.0025), FitnessTerm("orb.ratio", 0.5), FitnessTerm("door.seen", 1.0))
)
BEST = 1.528
"""The largest fitness without noise, of a grid of 40 focal lengths and 31 pitches for each sensor."""

SENSORS = find_catalog("image_sensors")
RIG = MonocularRig(MonocularRig.Config())


class CameraProblem:
    """The design problem and its simulator.

    `seed`: of the scenes and of the noise. `episodes`: number of scenes.
    """

    def __init__(self, seed: int, episodes: int = 4, scheme: str = "quantized") -> None:
        sensors = CatalogChoice("sensor", SENSORS, scheme)
        self.space = DesignSpace(
            [Continuous("pitch_deg", -30, 30, "deg"), Continuous("focal_length_mm", 1, 20, "mm"), sensors]
        )
        self.rng = np.random.default_rng(seed)
        self.gains = np.exp(0.15 * self.rng.standard_normal(episodes))
        self.tilts_deg = 4 * self.rng.standard_normal(episodes)
        self.images = 0
        self.problem = DesignProblem(
            fitness=FITNESS,
            episodes=episodes,
            coordinates=self.coordinates,
            broken=self.broken,
            scales={"orb.inliers": "count", "orb.ratio": "share", "door.seen": "share"},
            depends_on={"door.seen": ("pitch_deg", "hfov_deg", "vfov_deg")},
        )

    def coordinates(self, candidate: Candidate) -> Mapping[str, float]:
        return RIG.coordinates(RIG.Variables(**candidate.values))

    def broken(self, candidate: Candidate) -> Mapping[str, float]:
        hfov_deg = RIG.derived(RIG.Variables(**candidate.values))["hfov_deg"]
        return {"hfov_deg": hfov_deg - 140} if hfov_deg > 140 else {}

    def expected(self, candidate: Candidate, episode: int | None) -> dict[str, float]:
        """Scores without noise, in a scene or in the one between all."""
        c = self.coordinates(candidate)
        gain = 1.0 if episode is None else self.gains[episode]
        tilt_deg = 0.0 if episode is None else self.tilts_deg[episode]
        megapixels = 2 ** (c["log2_width_px"] + c["log2_height_px"] - 20)
        detail = megapixels**0.25 / (1 + math.exp((c["hfov_deg"] - 95) / 12))
        overlap = 1 / (1 + math.exp((40 - c["hfov_deg"]) / 10))
        clean = 1 / (1 + math.exp((1.0 - c["log2_pixel_um"]) / 0.6))
        lowest_deg = c["pitch_deg"] - c["vfov_deg"] / 2
        in_view = 1 / (1 + math.exp((lowest_deg + 42 + tilt_deg) / 5))
        level = math.exp(-(((c["pitch_deg"] + 5) / 25) ** 2))
        return {
            "orb.inliers": 160 * gain * detail * overlap * (0.4 + 0.6 * clean) * level,
            "orb.ratio": 0.1 + 0.5 * overlap * clean * level,
            "door.seen": in_view,
        }

    def worth(self, candidate: Candidate) -> float:
        """The fitness without noise."""
        return FITNESS.value(self.expected(candidate, None))

    def score(self, candidate: Candidate, episode: int) -> dict[str, float]:
        """Scores of one scene, with their noise."""
        found = self.expected(candidate, episode)
        return {
            "orb.inliers": float(self.rng.poisson(found["orb.inliers"])),
            "orb.ratio": float(np.clip(found["orb.ratio"] + 0.03 * self.rng.standard_normal(), 0, 1)),
            "door.seen": self.rng.binomial(3, found["door.seen"]) / 3,
        }

    def evaluate(self, asked: Candidate | Asked) -> Evaluated:
        """As a study does."""
        candidate, episodes = (asked.candidate, asked.episodes) if isinstance(asked, Asked) else (asked, None)
        if broken := self.broken(candidate):
            return Evaluated(candidate, None, "breaks a constraint", broken=broken)
        numbers: Sequence[int] = range(self.problem.episodes) if episodes is None else episodes
        scores = {number: self.score(candidate, number) for number in numbers}
        self.images += 8 * len(scores)
        means = {name: float(np.mean([s[name] for s in scores.values()])) for name in scores[numbers[0]]}
        return Evaluated(candidate, FITNESS.value(means), episodes=scores, images=8 * len(scores))

    def search(self, optimizer: Any, images: int) -> float:
        """Spend so many images; how far what is then recommended stays behind the best there is."""
        known: dict[Candidate, float] = {}
        while optimizer.stop() is None and self.images < images:
            results = [self.evaluate(asked) for asked in optimizer.ask()]
            known |= {r.candidate: r.fitness for r in results if r.fitness is not None}
            optimizer.tell(results)
        recommend = getattr(optimizer, "recommend", None)
        best = recommend(1)[0] if recommend else max(known, key=lambda candidate: known[candidate])
        return BEST - self.worth(best)
