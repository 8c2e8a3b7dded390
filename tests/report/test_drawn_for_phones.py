"""Every drawing of the reports of procedures and of ``tacos view`` says the same in the width of a phone."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from tacos_framework.catalog import find_catalog
from tacos_framework.simulation import Evaluation
from tacos_plugins.noise_calibration.figure import Cloud, photon_transfer
from tacos_plugins.noise_calibration.levels import Levels
from tacos_plugins.pretraining.pages import _curves as passes_curve
from tacos_report.figures.canvas import NARROW_IN
from tacos_validation.blind.confusion import confusion
from tacos_validation.blind.drawings import _severities as severities
from tacos_validation.blind.figure import Figure
from tacos_validation.cameras_validated.figures import levels, noise
from tacos_validation.cameras_validated.noise_curves import NoiseCurve
from tacos_validation.cameras_validated.ranking import CameraScores
from tacos_validation.optimizers_compared.outcome import Comparison
from tacos_validation.optimizers_compared.pages import _regret_curve as regret_curve
from tacos_validation.optimizers_compared.standings import JudgedRun, standings
from tacos_validation.rank_agreement.agreement import Agreement
from tacos_validation.rank_agreement.outcome import RankedLight
from tacos_validation.rank_agreement.pages import _slopes as slopes
from tacos_validation.studies_compared.pages import StudiesComparison
from tacos_validation.studies_compared.pages import _by_variant as by_variant
from tacos_validation.studies_compared.pairs import StudyOutcome
from tacos_validation.studies_table.findings import StudyRun
from tacos_validation.studies_table.pages import TableOutcome
from tacos_validation.studies_table.pages import _curves as study_curves
from tacos_view.catalog_sheet import outlines, sheet

CAMERAS = ("oak_d_pro_wide", "flea3", "basler_dart")
CHECKPOINTS = [10 * 2**i for i in range(9)]
RNG = np.random.default_rng(1)


def a_comparison() -> Comparison:
    """Eight optimizers, each with two runs that get better."""
    names = ["genetic", "random", "cma-es", "bayesian", "policy", "racing", "pareto", "surrogate"]
    runs = {
        name: [
            JudgedRun(
                name, seed, {at: at for at in CHECKPOINTS}, {at: 1 - (9 - i) / at for at in CHECKPOINTS}
            )
            for seed in (1, 2)
        ]
        for i, name in enumerate(names)
    }
    stand = standings(
        runs,
        target=0.9,
        best_known=1.0,
        against={},
        budgets=dict.fromkeys(names, 2560),
        thought_ms=dict.fromkeys(names, 1.0),
    )
    return Comparison("toy", "genetic after 640", 0.9, 640, 1.0, {}, 4, runs, stand, 9999, ())


def a_light() -> RankedLight:
    """Three cameras, two of which change places at full size."""
    fitness = {
        "quick": dict(zip(CAMERAS, (0.3, 0.2, 0.2), strict=True)),
        "full": dict(zip(CAMERAS, (0.3, 0.1, 0.2), strict=True)),
    }
    evaluations = {
        size: {name: Evaluation(values={}, fitness=value) for name, value in own.items()}
        for size, own in fitness.items()
    }
    return RankedLight("night", Agreement(0.8, None), {}, evaluations)


def some_studies() -> StudiesComparison:
    """Two variants with two seeds."""
    outcomes = [
        StudyOutcome(variant, seed, {"fitness": 0.1 * seed, "detect.found": 0.2}, {}, 9, 9.0)
        for variant in ("joint", "frozen")
        for seed in (1, 2)
    ]
    return StudiesComparison("toy", "frozen", tuple(outcomes), ("detect.found",))


def some_curves() -> TableOutcome:
    """Two studies whose fitness rises."""
    lines = [{"frames": 10, "best": {"fitness": 0.1 * i}} for i in range(5)]
    runs = tuple(StudyRun(study, 1, {}, lines) for study in ("genetic", "random"))
    return TableOutcome(None, (), runs, ())  # type: ignore[arg-type]


def some_scores() -> CameraScores:
    """Three cameras on four scenes."""
    drawn = {stack: RNG.uniform(0, 1, (3, 4)) for stack in ("real", "sim_before", "sim_after")}
    errors = {stack: np.full((3, 4), 0.02) for stack in drawn}
    return CameraScores("features.inliers", CAMERAS, tuple("abcd"), drawn, errors)


def a_noise_curve() -> NoiseCurve:
    """Variance that rises with the signal, alike in reality and in both simulations."""
    mean = np.linspace(10, 200, 12)
    plain = np.zeros_like(mean)
    found = Levels(mean, 1 + 0.24 * mean, plain, plain, plain, plain, 1.0, 0, 9)
    return NoiseCurve(dict.fromkeys(("real", "sim_before", "sim_after"), found), {})


def a_cloud(channel: str) -> Cloud:
    """Variance along its line."""
    signal = np.linspace(10, 200, 12)
    line = 1 + 0.24 * signal
    return Cloud(channel, signal, line * 1.01, 0.1 * line, signal < 180, line)


DRAWN: dict[str, tuple[Callable[..., str], list[str]]] = {
    "confusion": (
        partial(confusion, "charts", {"prnu": Counter(prnu=5, no_gap=2, dsnu=1), "jpeg": Counter(jpeg=4)}),
        ["prnu", "no gap", "jpeg", "charts"],
    ),
    "severities": (
        partial(severities, [(at, Figure("", 0.9, 0.8, 0.95, 9)) for at in (0.5, 1, 2, 4, 8)]),
        ["severity [noise floor]", "first cause right"],
    ),
    "regret": (partial(regret_curve, a_comparison()), ["surrogate", "images rendered", "2560"]),
    "slopes": (partial(slopes, a_light()), ["oak_d_pro_wide", "flea3 (equal)", "at full size"]),
    "by variant": (partial(by_variant, some_studies()), ["Fitness", "frozen", "seed 2"]),
    "study curves": (partial(study_curves, some_curves()), ["genetic", "best fitness so far"]),
    "levels": (partial(levels, some_scores(), 1), ["oak_d_pro_wide", "simulated with the causes"]),
    "noise": (partial(noise, dict.fromkeys(CAMERAS, a_noise_curve())), ["flea3", "variance [DN²]", "real"]),
    "photon transfer": (
        partial(photon_transfer, "p", [("30 ms", [a_cloud("R")]), ("8 ms", [a_cloud("G")])], line="a line"),
        ["30 ms", "8 ms", "R, measured", "off the line [%]"],
    ),
    "passes": (partial(passes_curve, "l", [1, 2], {"box": [2.0, 1.0]}, "loss", "Losses."), ["loss"]),
    "sensors": (
        partial(sheet, "s", outlines(find_catalog("image_sensors")), "all"),
        ["IMX219", "3280 x 2464, 1.12 um", "10 mm", "rolling"],
    ),
    "lenses": (
        partial(sheet, "l", outlines(find_catalog("lenses")), "all"),
        ["10 mm", "CS", "mount not stated"],
    ),
}


@pytest.mark.parametrize(("drawn", "told"), DRAWN.values(), ids=DRAWN)
def test_phones_are_told_the_same_in_their_own_width(drawn: Callable[..., str], told: list[str]) -> None:
    wide, narrow = (drawn(narrow=narrow) for narrow in (False, True))
    assert width_in(narrow) == pytest.approx(NARROW_IN, abs=0.01) != width_in(wide)
    for svg in (wide, narrow):
        words = " | ".join(re.findall(r"<text[^>]*>([^<]*)<", svg))
        assert [each for each in told if each not in words] == []


def width_in(svg: str) -> float:
    """Width of a drawing [in]."""
    (width_pt,) = re.findall(r'viewBox="0 0 ([\d.]+) ', svg)
    return float(width_pt) / 72
