"""Claims: verdicts from differences seed by seed, studies planned and run, and faults of a recipe."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import ValidationError
from scipy.stats import ttest_rel
from toy_study import LEARNER, toy_recipe

from tacos_framework import ProcedureRecipe, UserError, load_recipe, run
from tacos_framework.plan.procedure import plan_procedure
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Use
from tacos_validation.claims.compare import ClaimsTested
from tacos_validation.claims.settings import Claim
from tacos_validation.claims.verdicts import DOES_NOT, HOLDS, UNDECIDED, ClaimFound, judged
from tacos_validation.studies_table.findings import StudyRun


def study_run(seed: int, fitness: float, best: Sequence[tuple[int, float]] = ()) -> StudyRun:
    generations = [{"frames": frames, "best": {"fitness": value}} for frames, value in best]
    return StudyRun("any", seed, {"test": {"designed": {"fitness": fitness}}, "cameras": {}}, generations)


def verdict(own: Sequence[float], other: Sequence[float], **claim: Any) -> ClaimFound:
    runs = {
        name: {seed: study_run(seed, value) for seed, value in enumerate(values)}
        for name, values in (("own", own), ("other", other))
    }
    asked = Claim(says="Own is better.", of="own", over=("other",), **claim)
    return judged("better", asked, "toy", runs, 0.95)


OWN, OTHER = [1.0, 1.2, 0.9, 1.1], [0.8, 0.9, 0.7, 1.0]


def test_the_interval_is_that_of_a_paired_t_test():
    (found,) = verdict(OWN, OTHER).contrasts
    reference = ttest_rel(OWN, OTHER).confidence_interval(0.95)
    assert (found.low, found.high) == pytest.approx((reference.low, reference.high))
    assert found.seeds == 4


@pytest.mark.parametrize(
    ("claim", "expected"),
    [
        ({}, HOLDS),
        ({"better": "lower"}, DOES_NOT),
        ({"equal_within": 0.5}, HOLDS),
        ({"equal_within": 0.2}, UNDECIDED),
        ({"equal_within": 0.01}, DOES_NOT),
    ],
)
def test_a_claim_holds_where_its_interval_supports_it(claim, expected):
    assert verdict(OWN, OTHER, **claim).verdict == expected


def test_seeds_that_scatter_leave_it_undecided():
    assert verdict([1.0, 0.5, 1.5], [0.9, 0.9, 0.9]).verdict == UNDECIDED


def test_it_has_to_hold_over_every_rival():
    runs = {
        "own": {seed: study_run(seed, value) for seed, value in enumerate(OWN)},
        "weak": {seed: study_run(seed, value) for seed, value in enumerate(OTHER)},
        "strong": {seed: study_run(seed, value + 1) for seed, value in enumerate(OTHER)},
    }
    over_both = Claim(says="Own is best.", of="own", over=("weak", "strong"))
    assert judged("best", over_both, "toy", runs, 0.95).verdict == DOES_NOT
    del runs["strong"]
    found = judged("best", over_both, "toy", runs, 0.95)
    assert found.verdict == UNDECIDED
    assert [each.over for each in found.contrasts] == ["weak"]


def test_images_count_until_both_searches_are_as_good_as_the_worse_end():
    quick, slow = (
        [(10, 0.5), (10, 0.9), (10, 1.0)],
        [(40, 0.2), (40, 0.9)],
    )  # 0.9 after 20 and after 80 images
    runs = {
        "quick": {seed: study_run(seed, 0.0, quick) for seed in range(2)},
        "slow": {seed: study_run(seed, 0.0, slow) for seed in range(2)},
    }
    asked = Claim(says="Quick needs fewer.", of="quick", over=("slow",), value="images", better="lower")
    (found,) = judged("fewer", asked, "toy", runs, 0.95).contrasts
    assert found.mean == pytest.approx(math.log2(20 / 80))
    assert found.verdict == HOLDS


def test_a_search_that_scored_nothing_has_no_images_to_compare():
    runs = {
        "quick": {seed: study_run(seed, 0.0, [(10, 1.0)]) for seed in range(3)},
        "lost": {seed: study_run(seed, 0.0, [(10, 1.0)] if seed else []) for seed in range(3)},
    }
    asked = Claim(says="Quick needs fewer.", of="quick", over=("lost",), value="images", better="lower")
    (found,) = judged("fewer", asked, "toy", runs, 0.95).contrasts
    assert found.seeds == 2


# --- run on toys --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("study") / "toy.yaml"
    sections = {**LEARNER, "optimizer": {"population": 3, "keep": 1, "parents": 2, "generations": 2}}
    path.write_text(yaml.safe_dump(toy_recipe(**sections).as_data()))
    return str(path)


def asked(study: str, **settings: Any) -> ProcedureRecipe:
    base: dict[str, Any] = {
        "seeds": 2,
        "change": {study: {"test.frames": 2}},
        "scorings": {
            "both": {},
            "learner alone": {study: {"fitness": [{"score": "learner.knowledge", "weight": 1}]}},
        },
        "studies": {
            "joint": {"study": study},
            "frozen": {"study": study, "change": {"nodes.learner.train.weights": "frozen"}},
        },
        "claims": {"joint": {"says": "Joint beats frozen.", "of": "joint", "over": ["frozen"]}},
    }
    return ProcedureRecipe(
        "procedure.claims", base | settings, name="c", seed=7, executor=Use(use="executor.local")
    )


@pytest.fixture(scope="module")
def tested(study, reporting_toys, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    out = tmp_path_factory.mktemp("claims") / "out"
    return run(asked(study), out=out, plugins=reporting_toys), out


def test_each_study_runs_with_each_scoring_and_seed(tested):
    result, out = tested
    names = {path.name for path in (out / "studies").iterdir()}
    assert names == {
        f"{scoring}-{study}-{seed}"
        for scoring in ("both", "learner_alone")
        for study in ("joint", "frozen")
        for seed in (7, 8)
    }
    assert result["studies"] == 8
    assert [(each["claim"], each["scoring"]) for each in result["claims"]] == [
        ("joint", "both"),
        ("joint", "learner alone"),
    ]


def test_differences_are_those_of_twins(tested):
    result, out = tested

    def fitness(study: str, seed: int) -> float:
        kept = json.loads((out / "studies" / f"both-{study}-{seed}" / "result.json").read_text())
        return float(kept["test"]["designed"]["fitness"])

    by = [fitness("joint", seed) - fitness("frozen", seed) for seed in (7, 8)]
    (found,) = result["claims"][0]["contrasts"]
    assert found["mean"] == pytest.approx(sum(by) / 2)
    assert (out / "claims.csv").read_text().splitlines()[0].startswith("claim,scoring,verdict")
    assert "Joint beats frozen." in (out / "report.html").read_text()


def test_studies_that_are_done_are_kept_and_a_broken_one_goes_on(
    tested, study, reporting_toys, tmp_path, third_study_breaks_off
):
    whole, _ = tested
    with pytest.raises(KeyboardInterrupt):
        run(asked(study), out=tmp_path / "out", plugins=reporting_toys)
    result = run(asked(study), out=tmp_path / "out", plugins=reporting_toys, resume=True)
    first, second, broken, *later = third_study_breaks_off
    assert later[0] == broken
    assert {first, second}.isdisjoint(later)
    assert len(later) == 6
    assert result["claims"] == whole["claims"]


def test_what_is_skipped_is_not_run(study, reporting_toys, tmp_path):
    same = {"says": "Twins are equal.", "of": "joint", "over": ["joint"], "equal_within": 1}
    claims = {"joint": {"says": "Joint beats frozen.", "of": "joint", "over": ["frozen"]}, "same": same}
    recipe = asked(study, claims=claims, skip=["joint", "learner alone"])
    result = run(recipe, out=tmp_path / "out", plugins=reporting_toys)
    ran = {path.name for path in (tmp_path / "out" / "studies").iterdir()}
    assert ran == {"both-joint-7", "both-joint-8"}
    assert [(each["claim"], each["scoring"]) for each in result["claims"]] == [("same", "both")]


# --- recipes ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"claims": {"c": {"says": "s", "of": "joined", "over": ["frozen"]}}}, "no study 'joined'"),
        ({"change": {"other": {}}}, "keys for 'other', which no study uses"),
        ({"optional": ["rl"]}, "optional names no study 'rl'"),
        ({"skip": ["jointly"]}, r"skip names no claim and no scoring 'jointly'\. Did you mean 'joint'"),
        ({"skip": ["joint"]}, "skip leaves no claim"),
        ({"seeds": 1}, "greater than or equal to 2"),
    ],
)
def test_what_does_not_fit_together_is_refused(study, settings, match):
    with pytest.raises(ValidationError, match=match):
        ClaimsTested.Config.model_validate(asked(study, **settings).settings)


def test_a_product_that_a_study_does_not_compare_with_is_refused(study, reporting_toys):
    claims = {"c": {"says": "s", "of": "joint", "over": ["joint/flea4"]}}
    with pytest.raises(UserError, match="compares with no camera 'flea4'"):
        plan_procedure(asked(study, claims=claims), reporting_toys)


def test_the_shipped_claims_can_run():
    recipe = load_recipe("paper_claims", {"seeds": 2})
    assert isinstance(recipe, ProcedureRecipe)
    plan_procedure(recipe, Plugins.discover())
    assert len(recipe.settings["claims"]) == 8
