"""Real captures with known truth, from `../shared/data/real` beside the checkout; skipped where absent."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.plugins import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import read_captures
from tacos_gap.hypotheses.candidates import candidates
from tacos_validation.blind.real_cases import real_cases

DATA = Path(__file__).parents[3] / "shared" / "data" / "real"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory):
    """Diagnoses a case by its name, each once."""
    effects = candidates(Plugins.discover())
    cases = {case.name: case for case in real_cases(DATA)}
    found: dict[tuple[str, int], Diagnosis] = {}

    def of(name: str, seed: int = 0) -> Diagnosis:
        if (name, seed) not in found:
            folder = tmp_path_factory.mktemp("case")
            cases[name].write(folder)
            found[name, seed] = diagnose(read_captures(folder / "captures"), effects, seed=seed)
        return found[name, seed]

    return of


def test_chessboards_of_a_wide_lens_lead_to_its_distortion(diagnosed):
    found = diagnosed("chessboards, first half")
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    assert found.verdict == "explained"
    # of a fit of all views by k1 alone, of which k2 and k3 take a part here
    assert found.causes[0].parameters["k1"].value == pytest.approx(-0.281, rel=0.15)
    assert found.causes[0].closure >= 0.9


def test_chessboards_of_a_compact_camera_lead_to_its_distortion(diagnosed):
    first = diagnosed("chessboards by a compact").causes[0]
    assert (first.effect, first.present > 0.9) == ("lens-distortion", True)
    # the calibration that comes with the pictures; k3 takes a part here
    assert first.parameters["k1"].value == pytest.approx(-0.256, rel=0.15)


@pytest.mark.slow
def test_a_chart_through_raw_colour_filters_leads_to_their_matrix(diagnosed):
    first = diagnosed("chart in the sun").causes[0]
    assert (first.effect, first.present > 0.7) == ("colour-matrix", True)
    matrix = first.parameters["matrix"].value
    assert all(0.4 < matrix[k][k] < 0.95 for k in range(3))  # filters overlap, and none passes another's most


@pytest.mark.slow
def test_a_processed_bracket_leads_to_its_tone_curve(diagnosed):
    assert [cause.effect for cause in diagnosed("processed bracket").causes] == ["tone-curve"]


@pytest.mark.parametrize("times", ["25 and 50 ms", "50 and 100 ms", "25 to 100 ms"])
def test_short_darks_show_no_gap(diagnosed, times):
    found = diagnosed(f"short darks, {times}")
    assert found.verdict == "no_gap"
    assert found.causes == []


@pytest.mark.parametrize("times", ["500 and 2000 ms", "2000 and 3916 ms"])
def test_long_darks_lead_to_dark_current(diagnosed, times):
    found = [diagnosed(f"long darks, {times}", seed) for seed in range(3)]
    assert {tuple(cause.effect for cause in each.causes) for each in found} == {("dark-current",)}
    # by luck alone one simulation in seventeen stands out from its own replicates
    assert [each.verdict for each in found].count("explained") >= 2


@pytest.mark.slow
def test_clipping_below_the_believed_white_level_is_saturation_first(diagnosed):
    found = diagnosed("series to 2000 ms, believed wider")
    assert found.causes[0].effect == "saturation"


@pytest.mark.slow
@pytest.mark.parametrize("step", [1, 4, 7])
def test_nothing_strange_is_named_with_confidence_in_a_focus_stack(diagnosed, step):
    """The lens breathes, and depth spreads the blur: the blur may be found, and little else may."""
    found = diagnosed(f"focus stack, step {step}")
    assert found.verdict in ("unknown", "partly_explained")
    known = {case.name: case.known for case in real_cases(DATA)}[f"focus stack, step {step}"]
    assert {cause.effect for cause in found.causes if cause.present > 0.5} <= {*known.accept, *known.also}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "effect"), [("text, motion", "motion-blur"), ("text, defocus", "defocus")])
def test_blurred_print_leads_to_its_blur(diagnosed, name, effect):
    first, *others = diagnosed(name).causes
    assert first.effect == effect
    assert first.present > 0.7
    assert {cause.effect for cause in others if cause.present > 0.5} <= {"jpeg", "sharpening"}
