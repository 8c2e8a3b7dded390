"""Findings of a validation: scores of every camera in both simulators, and their rank agreement."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_validation.task_validation.acquisition import Taken
from tacos_validation.task_validation.agreement import (
    Agreement,
    OverSeeds,
    level_agreement,
    over_seeds,
    rank_agreement,
    separations,
    within,
)


@dataclass(frozen=True, eq=False)
class ValidationFindings:
    cameras: tuple[str, ...]
    titles: tuple[str, ...]
    score: str  # the score that ranks them
    exposures: tuple[str, ...]
    simulated: tuple[Taken, ...]  # for each camera what it came to in the simulator
    reference: tuple[Taken, ...]  # the same in what stands for reality

    def scores(self, taken: tuple[Taken, ...], name: str = "") -> NDArray[np.float64]:
        """(settings, seeds, cameras, pairs) of a score, by default of the one that ranks."""
        return np.stack([each.scores[name or self.score] for each in taken], axis=2)

    @property
    def places(self) -> int:
        return len(self.reference[0].on_target_px)

    def overall(self, setting: int) -> Agreement:
        """Agreement on the cameras by the mean over all pairs of places."""
        ours, theirs = (self.scores(taken)[setting].mean(axis=-1) for taken in self._both)
        return rank_agreement(ours, theirs)

    def at_pair(self, setting: int, pair: int) -> Agreement:
        ours, theirs = (self.scores(taken)[setting, ..., pair] for taken in self._both)
        return rank_agreement(ours, theirs)

    def floor_at_pair(self, setting: int, pair: int) -> Agreement:
        """Agreement of the reference with itself there, under one noise and under another."""
        return within(self.scores(self.reference)[setting, ..., pair])

    def per_pair(self, setting: int) -> OverSeeds:
        """Kendall's tau at a pair of places, mean over the pairs, seed by seed."""
        ours, theirs = (self.scores(taken)[setting] for taken in self._both)
        taus = [
            [rank_agreement(a[None, :, pair], b[None, :, pair]).tau.mean for pair in range(a.shape[-1])]
            for a, b in zip(ours, theirs, strict=True)
        ]
        return over_seeds(np.mean(taus, axis=1))

    def levels(self, setting: int) -> OverSeeds:
        """Rank correlation of the scores themselves, over all cameras and pairs of places."""
        ours, theirs = (self.scores(taken)[setting] for taken in self._both)
        return level_agreement(ours.reshape(len(ours), -1), theirs.reshape(len(theirs), -1))

    @property
    def everything(self) -> Agreement:
        """Agreement on every camera under every exposure, all against all."""
        ours, theirs = (self._every_case(taken) for taken in self._both)
        return rank_agreement(ours, theirs)

    @property
    def everything_floor(self) -> Agreement:
        """The same of the reference with itself under other noise."""
        return within(self._every_case(self.reference))

    def order(self, taken: tuple[Taken, ...], setting: int) -> list[int]:
        """The cameras from the best to the worst, by mean over pairs and seeds."""
        return np.argsort(-self.scores(taken)[setting].mean(axis=(0, 2)), kind="stable").tolist()

    def same_order(self, setting: int) -> bool:
        return self.order(self.simulated, setting) == self.order(self.reference, setting)

    def nearest(self, setting: int) -> tuple[int, int, float]:
        """The neighbours in the reference's ranking that are hardest to tell apart; see `separations`."""
        means = self.scores(self.reference)[setting].mean(axis=-1)
        return min(separations(means), key=lambda found: found[2])

    def level(self, taken: tuple[Taken, ...], setting: int, camera: int, name: str = "") -> OverSeeds:
        """Mean over the pairs of places of a score."""
        return over_seeds(self.scores(taken, name)[setting, :, camera].mean(axis=-1))

    @property
    def _both(self) -> tuple[tuple[Taken, ...], tuple[Taken, ...]]:
        return self.simulated, self.reference

    def _every_case(self, taken: tuple[Taken, ...]) -> NDArray[np.float64]:
        """(seeds, settings * cameras) means over the pairs."""
        means = self.scores(taken).mean(axis=-1)
        return np.moveaxis(means, 1, 0).reshape(means.shape[1], -1)

    def as_data(self) -> dict[str, Any]:
        pairs = range(self.places - 1)
        names = list(self.reference[0].scores)
        return {
            "score": self.score,
            "cameras": list(self.cameras),
            "exposures": [
                {
                    "exposure": words,
                    "order": {
                        "simulator": [self.cameras[i] for i in self.order(self.simulated, k)],
                        "reference": [self.cameras[i] for i in self.order(self.reference, k)],
                    },
                    "overall": asdict(self.overall(k)),
                    "per_pair": asdict(self.per_pair(k)),
                    "levels": asdict(self.levels(k)),
                    "pairs": [
                        {"agreement": asdict(self.at_pair(k, i)), "floor": asdict(self.floor_at_pair(k, i))}
                        for i in pairs
                    ],
                    "scores": {
                        camera: {
                            name: {
                                "simulator": asdict(self.level(self.simulated, k, i, name)),
                                "reference": asdict(self.level(self.reference, k, i, name)),
                            }
                            for name in names
                        }
                        for i, camera in enumerate(self.cameras)
                    },
                }
                for k, words in enumerate(self.exposures)
            ],
            "everything": asdict(self.everything),
            "everything_floor": asdict(self.everything_floor),
            "luminance_ratio": {
                camera: ours.luminance_cd_m2 / theirs.luminance_cd_m2 if theirs.luminance_cd_m2 else None
                for camera, ours, theirs in zip(self.cameras, self.simulated, self.reference, strict=True)
            },
        }
