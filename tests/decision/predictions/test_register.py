"""The page of predictions says what the register holds."""

from __future__ import annotations

import re

from tacos_decision.predictions.register import misses_in, model_errors, shipped_register
from tests.docs.pages import ROOT

PAGE = (ROOT / "docs" / "explanation" / "predictions.md").read_text("utf-8")


def test_the_page_has_every_value_with_its_outcome() -> None:
    rows = re.findall(r"\| ([^|]+) \| ([^|]+) \| ([^|]+) \| (yes|no) \|", PAGE)
    misses = misses_in([shipped_register()])
    expected = {
        (
            miss.predicted.camera,
            f"{miss.predicted.value:.3g} ({miss.predicted.low:.3g} to {miss.predicted.high:.3g})",
            f"{miss.measured:.3g}",
            "yes" if miss.inside else "no",
        )
        for miss in misses
    }
    assert set(rows) == expected
    assert f"{sum(miss.inside for miss in misses)} of {len(misses)} lie inside" in PAGE
    assert (
        f"the model error of `inliers` is {model_errors(misses)['inliers'].relative:.0%}".replace("%", " %")
        in PAGE
    )
