"""Severity, commitments, tiers, and figures on made-up answers."""

from __future__ import annotations

import json
import math
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_framework.store import Results
from tacos_framework.store.database import DATABASE
from tacos_gap.captures import read_captures
from tacos_validation.blind.cases import Case
from tacos_validation.blind.figure import Figure, interval
from tacos_validation.blind.generators.acquisitions import new_camera, smallest
from tacos_validation.blind.generators.catalogue import CATALOGUE
from tacos_validation.blind.generators.confounders import PAIRS
from tacos_validation.blind.generators.light_effects import InjectedExposureError
from tacos_validation.blind.generators.nuisances import NUISANCES
from tacos_validation.blind.generators.severity import NoiseFloor, calibrated
from tacos_validation.blind.generators.specifications import (
    CAPTURES,
    KEPT_BACK,
    CaseSpecification,
    make_and_commit,
    reveal,
)
from tacos_validation.blind.pages import page
from tacos_validation.blind.records import CASES, kept_cases
from tacos_validation.blind.scoring import figures, ladder
from tacos_validation.blind.tiers import Counts, case_specifications


@pytest.fixture(scope="module")
def floor() -> NoiseFloor:
    rng = np.random.default_rng(0)
    camera = new_camera(rng, 96, 72, 1)
    return NoiseFloor(smallest(camera, rng), camera, 1)


def test_nothing_wrong_has_no_severity(floor: NoiseFloor) -> None:
    assert floor.severity([]) == 0


def test_severity_grows_with_the_effect(floor: NoiseFloor) -> None:
    found = [floor.severity([InjectedExposureError(scale)]) for scale in (1.01, 1.05, 1.2)]
    assert found == sorted(found)
    assert found[0] < 2 < found[2]


@pytest.mark.parametrize("wanted", [1.0, 8.0])
def test_amplitudes_are_found_that_have_the_wanted_severity(floor: NoiseFloor, wanted: float) -> None:
    effect, units = calibrated(lambda a: InjectedExposureError(1 + a), wanted, floor, usual=0.3, largest=1.0)
    assert units == pytest.approx(wanted, rel=0.15)
    assert floor.severity([effect]) == pytest.approx(units)


def test_no_amplitude_beyond_the_largest(floor: NoiseFloor) -> None:
    effect, units = calibrated(lambda a: InjectedExposureError(1 + a), 100.0, floor, usual=0.01, largest=0.02)
    assert units < 5
    assert effect.parameters["scale"] <= 1.02


def test_a_case_is_committed_to_and_readable(tmp_path: Path) -> None:
    spec = CaseSpecification("ab12", 5, "T1", ("vignetting",), 8.0, "smallest", 96, 72, scored_on_fresh=True)
    commitment = make_and_commit(spec, tmp_path / "made", tmp_path / "truths")
    truth = reveal(commitment, tmp_path / "truths" / "ab12.json")
    assert truth["withheld"][0]["effect"] == "vignetting"
    for part in (CAPTURES, KEPT_BACK):
        folder = read_captures(tmp_path / "made" / "ab12" / part)
        assert len(folder.captures) == 4
    text = (tmp_path / "made" / "ab12" / CAPTURES / "captures.yaml").read_text()
    assert "vignetting" not in text


def test_a_changed_truth_is_noticed(tmp_path: Path) -> None:
    commitment = make_and_commit(
        CaseSpecification("ab12", 5, "T0", captures="smallest", width_px=96, height_px=72), tmp_path, tmp_path
    )
    file = tmp_path / "ab12.json"
    file.write_text(file.read_text().replace("T0", "T1"))
    with pytest.raises(ValueError, match="not the one that was committed to"):
        reveal(commitment, file)


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("split", [False, True])
def test_pairs_make_folders_that_can_be_read(pair: str, split: bool, tmp_path: Path) -> None:
    truth, notes = PAIRS[pair].truth, {"pair": pair, "split": split}
    spec = CaseSpecification("p", 3, "T6", (truth,), 4.0, "charts", 128, 96, notes=notes)
    make_and_commit(spec, tmp_path, tmp_path / "truths")
    read_captures(tmp_path / "p" / CAPTURES)


def test_a_broken_check_goes_on_with_its_cases_and_names_one_that_was_damaged(tmp_path: Path) -> None:
    results = Results(tmp_path)
    case = Case("c", "T0", {"withheld": []}, {"verdict": "no_gap", "causes": []}, None)
    for name in ("first", "second"):
        results.append_line(CASES, {**case.as_data(), "case": name})
    file = tmp_path / CASES
    file.write_bytes(file.read_bytes() + b'{"case": "cut')
    assert [each.name for each in kept_cases(results)] == ["first", "second"]
    with closing(sqlite3.connect(tmp_path / DATABASE)) as connection, connection:
        connection.execute("UPDATE entries SET value = replace(value, 'first', 'worst')")
    with pytest.raises(UserError, match=r"the digest of cases\.jsonl 0 does not fit"):
        kept_cases(results)


def test_tiers_hold_what_they_are_asked_for() -> None:
    counts = Counts(t0=3, ladder=(0.5, 8.0), t2=5, t3=len(CATALOGUE) + 2)
    made = case_specifications(counts, seed=1, size_px=(96, 72))
    assert len({spec.case for spec in made}) == len(made)
    count = {tier: [o for o in made if o.tier == tier] for tier in ("T0", "T1", "T2", "T3", "T6", "T7")}
    assert len(count["T0"]) == 3
    assert len([o for o in count["T1"] if o.captures != "natural"]) == 2 * len(CATALOGUE)
    own_captures = {o.effects: o.captures for o in made if o.captures == "two_gains"}
    assert own_captures == {("conversion-gain-mode",): "two_gains"}
    assert {o.effects for o in count["T3"]} == {(name,) for name in CATALOGUE}
    assert len(count["T3"]) == len(CATALOGUE) + 2
    assert all(o.removed == o.effects for o in count["T3"])
    assert all(2 <= len(set(o.effects)) <= 3 for o in count["T2"])
    assert len(count["T6"]) == 2 * len(PAIRS)
    assert len(count["T7"]) == 4 * len(NUISANCES)
    assert not any(set(o.effects) & NUISANCES[o.nuisance].veils for o in count["T7"])
    assert made == case_specifications(counts, seed=1, size_px=(96, 72))


# figures --------------------------------------------------------------------------------------------------


def case(tier: str, *withheld: str, named: tuple[str, ...] = (), **more: Any) -> Case:
    verdict = more.pop("verdict", "explained" if named else "no_gap")
    answer = {
        "verdict": verdict,
        "causes": [
            {"effect": n, "probability": 0.9, "parameters": {"scale": {"value": 1.19, "ci": [1.18, 1.25]}}}
            for n in named
        ],
        "cause_set": list(more.pop("cause_set", named)),
        "gap": {"before": 9.0, "after": 1.8},
        "negative_control": {"effect": "x", "closure": 0.02},
        "seconds": 30.0,
        "captures": 12,
        "patch": [],
    }
    specification = {
        "captures": "charts",
        "severity": 8.0,
        "notes": {},
        "variants": {},
        "nuisance": "",
        **more.pop("specification", {}),
    }
    truth = {
        "specification": specification,
        "withheld": [{"effect": n, "parameters": {"scale": 1.2}, "units": 8.0} for n in withheld],
        **more.pop("truth", {}),
    }
    return Case("c", tier, truth, answer, more.pop("fresh_gaps", None))


def figure(name: str, *cases: Case) -> Figure:
    (found,) = [each for each in figures(cases) if each.name == name]
    return found


def test_false_alarms_count_causes_and_unknowns() -> None:
    found = figure(
        "T0 false alarms", case("T0"), case("T0", named=("jpeg",)), case("T0", verdict="unknown"), case("T0")
    )
    assert found.value == 0.5
    assert found.met is False
    assert (found.low, found.high) == interval(2, 4)


def test_the_first_cause_counts_and_weak_cases_do_not() -> None:
    weak = case(
        "T1", "exposure-error", truth={"withheld": [{"effect": "prnu", "parameters": {}, "units": 1.0}]}
    )
    right = case("T1", "exposure-error", named=("exposure-error", "jpeg"))
    wrong = case("T1", "exposure-error", named=("jpeg", "exposure-error"))
    found = figure("T1 first cause right, charts", right, wrong, weak)
    assert (found.value, found.count) == (0.5, 2)


def test_natural_scenes_are_counted_apart() -> None:
    natural = case("T1", "prnu", named=("prnu",), specification={"captures": "natural"})
    assert figure("T1 first cause right, natural", natural).count == 1
    assert figure("T1 first cause right, charts", natural).count == 0


def test_sets_must_be_exact() -> None:
    exact = case("T2", "prnu", "jpeg", named=("jpeg", "prnu"))
    more = case("T2", "prnu", "jpeg", named=("jpeg", "prnu", "dsnu"))
    assert figure("T2 exact set", exact, more).value == 0.5
    more.answer["causes"][2]["present"] = 0.4
    assert figure("T2 exact set", exact, more).value == 0.5
    assert figure("T2 exact set, of presence above 50 %", exact, more).value == 1.0


def test_removed_effects_must_be_called_unknown() -> None:
    said = case("T3", "prnu", verdict="unknown")
    partly = case("T3", "prnu", named=("dsnu",), verdict="partly_explained")
    fooled = case("T3", "prnu", named=("dsnu",))
    assert figure("T3 says that something is unknown", said, partly, fooled).value == pytest.approx(2 / 3)
    assert figure("T3 verdict unknown, strictly", said, partly, fooled).value == pytest.approx(1 / 3)


def test_independent_makers_are_held_against_the_same_effects() -> None:
    charts = [case("T1", "jpeg", named=("jpeg",)), case("T1", "prnu", named=("dsnu",))]
    assert figure("T4 loss against T1, same effects", *charts, case("T4", "jpeg", named=("prnu",))).value == 1


def test_pairs_need_a_set_until_they_are_split() -> None:
    few = {"notes": {"pair": "x", "split": False}}
    split = {"notes": {"pair": "x", "split": True}}
    as_set = case("T6", "prnu", named=("prnu",), cause_set=("prnu", "dsnu"), specification=few)
    confident = case("T6", "prnu", named=("prnu",), specification=few)
    found = case("T6", "prnu", named=("prnu",), specification=split)
    assert figure("T6 a set, without the splitting capture", as_set, confident, found).value == 0.5
    assert figure("T6 right with the splitting capture", as_set, confident, found).value == 1


def known(*accept: str, **more: Any) -> dict[str, Any]:
    return {"known": {"accept": list(accept), **more}}


def test_real_cases_know_what_may_be_said() -> None:
    quiet = known("quantisation", expect_verdict=["no_gap"])
    assert case("T5", truth=quiet).right
    assert case("T5", named=("quantisation",), truth=quiet).right
    wrong = case("T5", named=("jpeg",), truth=quiet)
    assert wrong.confident_and_wrong
    assert case("T5", named=("defocus",), truth=known("defocus", "lens-blur")).right


def test_nuisances_may_be_named_but_not_first() -> None:
    truth = known("prnu", also=["jpeg"])
    right = case("T7", "prnu", named=("prnu", "jpeg"), truth=truth)
    late = case("T7", "prnu", named=("jpeg", "prnu"), truth=truth)
    beside = case("T7", "prnu", named=("prnu", "denoise"), truth=truth)
    broken = Case("c", "T7", right.truth, {"error": "no answer within 600 s"})
    cases = (right, late, beside, broken)
    assert figure("T7 first cause right", *cases).value == 0.5
    assert figure("T7 confident and wrong", *cases).value == 0.5
    assert figure("T7 no answer", *cases).value == 0.25


def test_nothing_withheld_beside_nuisances() -> None:
    truth = known("pose-error", also=["pose-error"], expect_verdict=["no_gap", "explained"])
    quiet, named, alarm = (
        case("T7", named=names, truth=truth) for names in ((), ("pose-error",), ("vignetting",))
    )
    assert (quiet.right, named.right, alarm.right) == (True, True, False)
    assert figure("T7 false alarms, nothing withheld", quiet, named, alarm).value == pytest.approx(1 / 3)


def test_parameters_are_measured_from_neutral() -> None:
    found = case("T1", "exposure-error", named=("exposure-error",))
    (parameter,) = found.parameters()
    assert parameter.relative_error == pytest.approx(0.01 / 0.2)
    assert parameter.holds
    assert parameter.relative_width == pytest.approx(0.035 / 0.2)
    assert parameter.half_widths_off == pytest.approx(0.01 / 0.06)
    assert case("T1", "exposure-error", named=("jpeg",)).parameters() == []


def test_closures_on_fresh_captures() -> None:
    fresh_gaps = {"before": 11.0, "found": 2.0, "truth": 1.0}
    cases = [case("T1", "prnu", named=("prnu",), fresh_gaps=fresh_gaps)]
    assert figure("Realised over oracle closure, fresh captures", *cases).value == pytest.approx(0.975)
    assert figure("Predicted less realised closure", *cases).value == pytest.approx(0.003)


def test_an_error_is_a_wrong_answer() -> None:
    broken = Case("c", "T1", case("T1", "prnu").truth, {"error": "ValueError: x"})
    assert not broken.right
    assert broken.first == "error"
    assert figure("T1 first cause right, charts", broken).value == 0


def test_no_cases_no_figures() -> None:
    for each in figures([]):
        assert math.isnan(each.value)
        assert each.met is None
        json.dumps(each.as_data(), allow_nan=False)


def test_a_case_survives_its_file() -> None:
    one = case("T1", "prnu", named=("prnu",))
    assert Case.of(json.loads(json.dumps(one.as_data()))).as_data() == one.as_data()


def test_the_page_shows_failures_by_name() -> None:
    cases = [case("T1", "prnu", named=("jpeg",)), case("T0")]
    built = page(cases, figures(cases), ["A note."])
    assert built.sections[0].title.startswith("What was withheld")
    assert "jpeg (90%)" in str(built.sections[-1])
    assert ladder(cases)[0][1].value == 0
