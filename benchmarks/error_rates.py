"""How often the sequential test errs when it looks several times: tables of docs/explanation/decision.md.

Run it with ``python benchmarks/error_rates.py``; it takes a minute.
"""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from tacos_framework.study import confidence_interval
from tacos_framework.study.sequential import error_at, looks

MOST, STUDIES, ERROR = 30, 4000, 0.05
LOOKS, LONG = looks(8, MOST), looks(8, 60)
RNG = np.random.default_rng(1)

DIFFERENCES = {
    "normal": lambda: RNG.standard_normal(MOST),
    "Student's t, 3 degrees of freedom": lambda: RNG.standard_t(3, MOST),
    "Laplace": lambda: RNG.laplace(size=MOST),
    "uniform": lambda: RNG.uniform(-1, 1, MOST),
    "skewed (gamma, shape 4)": lambda: RNG.gamma(4, size=MOST) - 4,
    "skewed (exponential)": lambda: RNG.exponential(size=MOST) - 1,
    "very skewed (log-normal)": lambda: RNG.lognormal(0, 1, MOST) - np.exp(0.5),
    "one threshold in ten missed, other noise 0.3 of it": lambda: _missed(0.1, 0.3),
    "three in ten missed, other noise 0.1 of it": lambda: _missed(0.3, 0.1),
    "one in ten missed, other noise 0.1 of it": lambda: _missed(0.1, 0.1),
}
"""Paired differences of cameras that are equal in the mean."""


def _missed(share: float, noise: float) -> np.ndarray:
    return RNG.normal(0, noise, MOST) + (RNG.random(MOST) < share) - share


def _errs(seen: np.ndarray) -> bool:
    ends = (confidence_interval(seen[:n], error_at(n, LOOKS, ERROR)) for n in LOOKS)
    return any(end is not None and not end[0] <= 0 <= end[1] for end in ends)


def _student_errs(seen: np.ndarray) -> bool:
    return any(
        abs(seen[:n].mean()) > stdtrit(n - 1, 1 - ERROR / 2) * seen[:n].std(ddof=1) / np.sqrt(n)
        for n in LOOKS
    )


def main() -> None:
    """Print the tables."""
    print("| differences | this test | Student's interval at every look |")
    print("| --- | --- | --- |")
    for name, draw in DIFFERENCES.items():
        studies = [draw() for _ in range(STUDIES)]
        own, student = np.mean([_errs(s) for s in studies]), np.mean([_student_errs(s) for s in studies])
        print(f"| {name} | {100 * own:.1f} % | {100 * student:.1f} % |")
    print("\n| difference, in spreads | scenes until decided, of 60 at most: quartiles |\n| --- | --- |")
    for effect in (2.0, 1.0, 0.5):
        needed = []
        for _ in range(500):
            seen = RNG.standard_normal(LONG[-1]) + effect
            ends = (confidence_interval(seen[:n], error_at(n, LONG, ERROR / 3)) for n in LONG)
            needed.append(next((n for n, e in zip(LONG, ends, strict=True) if e and e[0] > 0), LONG[-1]))
        print(f"| {effect:g} | {', '.join(f'{n:.0f}' for n in np.quantile(needed, [0.25, 0.5, 0.75]))} |")


if __name__ == "__main__":
    main()
