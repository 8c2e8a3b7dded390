"""Cases of the blind check that an earlier diagnosis took for something else, made anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.plugins import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import read_captures
from tacos_gap.hypotheses.candidates import candidates
from tacos_validation.blind.generators.specifications import CAPTURES, CaseSpecification, make


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "severity", "seed"),
    [
        ("defocus", 8.0, 3789519747986281491),  # of 1.1 px
        ("flicker", 8.0, 904349861463718292),  # its luck in a sequence: exposure that settles, with .96
    ],
)
def test_what_was_taken_for_another_comes_first(effect: str, severity: float, seed: int, tmp_path: Path):
    make(CaseSpecification("known", seed, "T1", (effect,), severity, "charts", 160, 120), tmp_path)
    found = diagnose(read_captures(tmp_path / CAPTURES), candidates(Plugins.discover()).effects, seed=0)
    assert found.causes[0].effect == effect
    assert found.verdict == "explained"


@pytest.mark.slow
def test_a_disc_of_less_than_a_pixel_is_in_the_set_beside_lens_blur(tmp_path: Path):
    """It was lens blur, with .91. Their scores differ by 2 to 4 nat either way; the standard error is 12."""
    make(
        CaseSpecification("known", 4234900957680020312, "T1", ("defocus",), 4.0, "charts", 160, 120), tmp_path
    )
    found = diagnose(read_captures(tmp_path / CAPTURES), candidates(Plugins.discover()).effects, seed=0)
    assert set(found.cause_set) == {"defocus", "lens-blur"}
    assert len(found.causes) == 1
    assert found.causes[0].present < 0.75


@pytest.mark.slow
@pytest.mark.parametrize(("nuisance", "severity"), [("lamp", 8.0), ("few frames", 4.0)])
def test_weak_bad_columns_and_rows_are_no_fixed_pattern(nuisance: str, severity: float, tmp_path: Path):
    """Three columns and a row that no single capture shows: columns were named a pattern of all of them."""
    spec = CaseSpecification(
        "known", 1, "T7", ("defect-lines",), severity, "charts", 160, 120, nuisance=nuisance
    )
    make(spec, tmp_path)
    found = diagnose(read_captures(tmp_path / CAPTURES), candidates(Plugins.discover()).effects, seed=0)
    assert [cause.effect for cause in found.causes if cause.present > 0.5] == ["defect-lines"]
