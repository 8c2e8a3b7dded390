"""What is looked for beside an effect that explains nearly all."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_gap.attribution import ForwardSelection
from tacos_gap.inference.problem import Problem
from tests.gap.attribution.test_pairs import GRADIENT, PATTERNS, PLACES, RIPPLE, Field, Gradient, Ripple

PART = np.arange(PLACES) // 40
STEEP = GRADIENT * np.array([100.0, 8.0, 1.0])[PART]


class Steep(Gradient):
    """Far above the noise floor in two statistics, as saturation of a bracket; in a third just above it."""

    patterns: ClassVar = (STEEP,)


class InOnePart(Ripple):
    """In the third alone."""

    patterns: ClassVar = (RIPPLE * (PART == 2),)


EFFECTS: dict[str, type[Any]] = {"steep": Steep, "ripple": InOnePart}


@pytest.mark.parametrize(("missed", "names"), [(4.0, ["steep"]), (0.0, ["ripple", "steep"])])
def test_what_formulas_miss_of_a_large_effect_brings_in_no_other_that_fits_a_bit_of_it(missed, names):
    rest = (3.0 * RIPPLE + missed * PATTERNS[2]) * (PART == 2)
    of = Problem([Field(4.0 * STEEP + rest)])
    found = ForwardSelection(of, EFFECTS).run()
    assert sorted(found.best.names) == names
    assert found.best.hypothesis[0].values["amount"] == pytest.approx(4.0, abs=0.3)
