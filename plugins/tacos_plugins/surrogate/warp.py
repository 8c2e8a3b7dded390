"""A gene stretched so that what images depend on changes evenly along it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Warp:
    """Maps 0..1 to a gene so that coordinates change evenly: a focal length, so that fields of view do."""

    genes: Array
    """(n,) rising values of the gene."""
    places: Array
    """(n,) where between 0 and 1 each of them lies."""

    @classmethod
    def of_sweep(cls, genes: Array, coordinates: Sequence[Mapping[str, float] | None]) -> Warp:
        """From the coordinates at values of the gene; None where a constraint is broken."""
        steps = np.full(len(genes) - 1, np.nan)
        known = [c for c in coordinates if c is not None]
        names = [n for n in (known[0] if known else {}) if all(n in c for c in known)]
        ranges = {n: max(c[n] for c in known) - min(c[n] for c in known) for n in names}
        moving = [n for n in names if ranges[n] > 1e-9 * max(1.0, *(abs(c[n]) for c in known))]
        for i, (one, other) in enumerate(pairwise(coordinates)):
            if moving and one is not None and other is not None:
                steps[i] = np.mean([abs(other[n] - one[n]) / ranges[n] for n in moving])
        usual = float(np.nanmean(steps)) if np.nansum(steps) > 0 else 1.0
        steps = np.where(np.isfinite(steps), steps, usual) + 1e-3 * usual  # no value is left out altogether
        places = np.concatenate([[0.0], np.cumsum(steps)])
        return cls(genes, places / places[-1])

    def gene(self, place: float) -> float:
        """The value at a place between 0 and 1."""
        return float(np.interp(place, self.places, self.genes))

    def place(self, gene: float) -> float:
        """Undoes :meth:`gene`."""
        return float(np.interp(gene, self.genes, self.places))
