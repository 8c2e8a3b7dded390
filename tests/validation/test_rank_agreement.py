"""Whether a small study ranks cameras as a big one: the statistics, the cameras, the procedure."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from toy_study import FROM_CATALOG, begun_as, merged

from tacos_framework import ProcedureRecipe, UserError, run
from tacos_framework.recipe import Use
from tacos_framework.simulation import Evaluation
from tacos_framework.store import Results
from tacos_framework.testing import ProcedureConformance
from tacos_validation.rank_agreement.agreement import (
    Agreement,
    DecidedPairs,
    agreement,
    agreement_of_halves,
    decided_pairs,
    places,
    tau_b,
)
from tacos_validation.rank_agreement.measure import RankAgreement
from tacos_validation.rank_agreement.outcome import RankedLight, RankOutcome

LOCAL = Use(use="executor.local")
PARTS = ["PYTHON300", "LUX1310", "IMX432", "IMX252"]
CAMERAS = {
    "products": ["oak_d_pro_wide", "flea3"],
    "parts": PARTS,
    "match": {"focal_length_mm": {"hfov_deg": 81.5}},
    "by_values": {},
    "at": {"pitch_deg": -20},
}


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("study") / "toy.yaml"
    path.write_text(yaml.safe_dump(merged(FROM_CATALOG, {"study": {"episodes": 3}})))
    return path


def asked(path: Path, **changed: Any) -> ProcedureRecipe:
    base = {
        "study": str(path),
        "full": {"rig.binning": 64},
        "lights": {"day": {"scenario.illumination_lux": 20}, "night": {"scenario.illumination_lux": 2}},
        "cameras": CAMERAS,
        "fewest": 2,
        "resamples": 20,
    }
    return ProcedureRecipe("procedure.rank-agreement", base | changed, name="r", executor=LOCAL)


@pytest.fixture(scope="module")
def ranked(study, toys, tmp_path_factory) -> tuple[dict[str, Any], Path]:
    out = tmp_path_factory.mktemp("ranked") / "out"
    return run(asked(study), out=out, plugins=toys), out


# statistics -------------------------------------------------------------------------------------------------


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])  # the first call loads scipy
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=2, max_size=9))
def test_tau_is_kendalls_by_counting_pairs(pairs):
    concordant = discordant = only_first = only_second = 0
    for (a, b), (c, d) in combinations(pairs, 2):
        if a == c or b == d:
            only_first += a == c and b != d
            only_second += b == d and a != c
        elif (a < c) == (b < d):
            concordant += 1
        else:
            discordant += 1
    apart = concordant + discordant
    scale = math.sqrt((apart + only_first) * (apart + only_second))
    found = tau_b([a for a, _ in pairs], [b for _, b in pairs])
    if scale == 0:
        assert found is None
    else:
        assert found == pytest.approx((concordant - discordant) / scale)


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])  # the first call loads scipy
@given(st.dictionaries(st.text(max_size=3), st.integers(-3, 3), min_size=1, max_size=8))
def test_places_count_those_that_are_better(fitness):
    for name, place in places(fitness).items():
        better = sum(other > fitness[name] for other in fitness.values())
        equal = sum(other == fitness[name] for other in fitness.values())
        assert place == better + (equal + 1) / 2


def _on(table: Mapping[str, list[float]]):
    return lambda name, scenes: float(np.mean([table[name][scene] for scene in scenes]))


def test_an_order_that_every_scene_gives_is_certain():
    table = {name: [value, value + 0.1, value - 0.1] for name, value in zip("abcd", range(4), strict=True)}
    rng = np.random.default_rng(1)
    found = agreement("abcd", _on(table), _on(table), 3, resamples=50, confidence=0.95, rng=rng)
    assert found.tau == 1
    assert found.interval == (1, 1)


def test_an_order_that_hangs_on_the_scenes_is_not():
    rng = np.random.default_rng(1)
    first, second = ({n: rng.normal(size=4).tolist() for n in "abcdef"} for _ in range(2))
    found = agreement("abcdef", _on(first), _on(second), 4, resamples=200, confidence=0.9, rng=rng)
    assert found.interval is not None
    assert found.interval[0] < found.tau < found.interval[1]
    assert found.interval[1] - found.interval[0] > 0.3


def test_one_scene_tells_no_interval():
    table = {"a": [1.0], "b": [2.0]}
    rng = np.random.default_rng(1)
    assert agreement("ab", _on(table), _on(table), 1, resamples=9, confidence=0.9, rng=rng).interval is None


def test_halves_that_say_the_same_agree_and_those_of_chance_alone_do_not():
    rng = np.random.default_rng(1)
    same = {name: [value] * 6 for name, value in zip("abcdef", range(6), strict=True)}
    assert agreement_of_halves("abcdef", _on(same), 6, resamples=9, rng=rng) == 1
    chance = {name: rng.normal(size=40).tolist() for name in "abcdefghijkl"}
    found = agreement_of_halves("abcdefghijkl", _on(chance), 40, resamples=99, rng=rng)
    assert found is not None
    assert abs(found) < 0.4
    assert agreement_of_halves("ab", _on({"a": [1.0], "b": [2.0]}), 1, resamples=9, rng=rng) is None


def test_pairs_count_as_decided_where_nearly_all_draws_of_scenes_agree():
    full = {"a": [3.0, 3.1, 2.9], "b": [2.0, 2.1, 1.9], "c": [1.0, 5.0, -3.0]}  # c hangs on the scenes
    small = {"a": [1.0, 1.0, 1.0], "b": [2.0, 2.0, 2.0], "c": [0.0, 0.0, 0.0]}
    counted = {"scenes": 3, "resamples": 200, "confidence": 0.95}
    rng = np.random.default_rng(1)
    assert decided_pairs("abc", _on(full), _on(full), rng=rng, **counted) == DecidedPairs(1, 1)
    assert decided_pairs("abc", _on(small), _on(full), rng=rng, **counted) == DecidedPairs(1, 0)
    assert decided_pairs("abc", _on(full), _on(full), rng=rng, **{**counted, "scenes": 1}) is None


# the procedure ----------------------------------------------------------------------------------------------


def test_the_table_has_both_orders(ranked):
    result, out = ranked
    assert set(result["tau"]) == {"day", "night"}
    by_light = [row for row in result["table"] if row["light"] == "day"]
    assert {row["camera"] for row in by_light} == {"oak_d_pro_wide", "flea3", *PARTS}
    for size in ("quick", "full"):
        ordered = sorted(by_light, key=lambda row: row[f"rank_{size}"])
        assert [row[size] for row in ordered] == sorted((row[size] for row in by_light), reverse=True)
    expected = tau_b([row["quick"] for row in by_light], [row["full"] for row in by_light])
    assert result["tau"]["day"] == expected
    assert len(list(csv.DictReader((out / "table.csv").read_text().splitlines()))) == 12
    assert result["cost"]["full"]["images"] == 2 * 6 * 3 * 3  # lights, cameras, scenes, frames


def test_what_both_studies_share_is_said(ranked):
    result, out = ranked
    assert "Both see the same scenes" in result["rank_notes"][0]
    assert set(result["tau_of_halves"]) == {"day", "night"}
    for text in (result["rank_notes"][0], (out / "report.html").read_text()):
        assert f"{result['tau_of_halves']['day']:.2f} by day" in text
    decided = result["pairs_decided"]["night"]
    assert 0 <= decided["alike"] <= decided["pairs"] <= 15
    assert f"tells {decided['pairs']} of 15 pairs" in result["rank_notes"][1]


def test_parts_are_seen_at_the_field_of_view_asked_for(study, toys):
    from tacos_framework.plan import make_plan
    from tacos_framework.recipe.loading import load_recipe
    from tacos_validation.rank_agreement.cameras import cameras_of
    from tacos_validation.rank_agreement.settings import RankedCameras

    plan = make_plan(load_recipe(study), toys)
    cameras = {c.name: c.values for c in cameras_of(RankedCameras.model_validate(CAMERAS), plan)}
    for part in PARTS:
        values = cameras[part]
        width_mm = values["sensor"]["width_px"] * values["sensor"]["pixel_um"] / 1000
        hfov_deg = 2 * math.degrees(math.atan(width_mm / 2 / values["focal_length_mm"]))
        assert hfov_deg == pytest.approx(81.5)
        assert values["pitch_deg"] == -20
    assert cameras["flea3"]["focal_length_mm"] == 3.6


def test_the_page_shows_both_orders(ranked):
    page = (ranked[1] / "report.html").read_text()
    assert page.count("<svg") == 4, "each once more for phones"
    assert "at full size" in page
    assert "None" not in page
    assert 'src="http' not in page


def test_the_gate_needs_enough_cameras(study, toys, tmp_path):
    result = run(asked(study, fewest=10), out=tmp_path / "out", plugins=toys)
    assert result["passes"] is False
    assert any("only 6 cameras" in doubt for doubt in result["doubts"])


def test_equal_studies_agree(study, toys, tmp_path):
    result = run(asked(study, full={"seed": 3}, gate=1.0), out=tmp_path / "out", plugins=toys)
    assert result["tau"] == {"day": 1.0, "night": 1.0}
    assert result["passes"] is True


def test_a_camera_that_breaks_a_constraint_is_named(study, toys, tmp_path):
    change = {"constraints.hfov_deg.max": 90}  # the OAK-D has 97.6
    result = run(asked(study, change=change), out=tmp_path / "out", plugins=toys)
    assert {row["camera"] for row in result["left_out"]} == {"oak_d_pro_wide"}
    assert "hfov_deg is 97.6" in result["left_out"][0]["why"]
    assert "oak_d_pro_wide" not in {row["camera"] for row in result["table"]}
    assert "oak_d_pro_wide has no place" in (tmp_path / "out" / "report.html").read_text()


def test_cameras_that_the_small_study_cannot_tell_apart_fail_it():
    """Tau-b forgives ties: four sensors that find nothing leave it at 0.93."""
    fitness = {
        "quick": dict(zip("abcdefghij", [6, 5, 4, 3, 2, 1, 0, 0, 0, 0], strict=True)),
        "full": dict(zip("abcdefghij", range(10, 0, -1), strict=True)),
    }
    evaluations = {
        size: {name: Evaluation(values={}, fitness=float(value)) for name, value in own.items()}
        for size, own in fitness.items()
    }
    tau = tau_b(list(fitness["quick"].values()), list(fitness["full"].values()))
    assert tau == pytest.approx(0.93, abs=0.005)
    light = RankedLight("night", Agreement(tau, None), {}, evaluations)
    outcome = RankOutcome("small", 0.8, 10, 0.95, 1, (light,), ())
    assert light.not_told_apart == ("g", "h", "i", "j")
    assert outcome.passes is False
    assert "the same fitness to cameras that differ at full size: g, h, i, j." in outcome.doubts[0]
    assert light.order("quick") == list("abcdefghij")


def test_all_equal_is_no_order(study, toys, tmp_path):
    change = {"nodes.width.fail_above_deg": 1}
    result = run(asked(study, change=change), out=tmp_path / "out", plugins=toys)
    assert result["tau"] == {"day": None, "night": None}
    assert result["passes"] is False
    assert result["table"] == []


def test_a_broken_run_goes_on_where_it_stopped(ranked, study, toys, tmp_path):
    import toy_plugin

    whole, finished = ranked
    out = begun_as(finished, tmp_path / "broken")
    kept = (finished / "scores.jsonl").read_text().splitlines()
    Results(out).write_lines("scores.jsonl", map(json.loads, kept[:50]))
    before = toy_plugin.WidthTask.begun
    again = run(asked(study), out=out, plugins=toys, resume=True)
    assert toy_plugin.WidthTask.begun - before == len(kept) - 50 == 2 * 2 * 6 * 3 - 50
    assert again["table"] == whole["table"]
    assert again["tau_interval"] == whole["tau_interval"]


def test_scores_of_another_study_are_not_taken_over(ranked, study, toys, tmp_path):
    finished = ranked[1]
    rows = [json.loads(line) for line in (finished / "scores.jsonl").read_text().splitlines()]
    assert len({row["study"] for row in rows}) == 4


def test_cameras_by_values_need_no_catalog(toys, tmp_path):
    from toy_study import toy_recipe

    path = tmp_path / "toy.yaml"
    path.write_text(yaml.safe_dump(toy_recipe().as_data()))
    cameras = {"by_values": {f"f{f}": {"focal_length_mm": f} for f in (1, 2, 3)}, "at": {"pitch_deg": 0}}
    result = run(asked(path, cameras=cameras, full={"rig.binning": 2}), out=tmp_path / "out", plugins=toys)
    assert [row["camera"] for row in result["table"] if row["light"] == "day"] == ["f1", "f2", "f3"]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"study": "rank_agreement"}, "is no study"),
        ({"full": {"rig.bining": 1}}, "unknown key 'bining'"),
        ({"cameras": {**CAMERAS, "parts": ["IMX43"]}}, "the study cannot choose a part 'IMX43'"),
        ({"cameras": {**CAMERAS, "products": ["zed_2i"]}}, "zed_2i fixes variables of rig.stereo"),
        ({"cameras": {**CAMERAS, "at": {}}}, "leaves pitch_deg free"),
        ({"cameras": {**CAMERAS, "at": {"pich_deg": 1, "pitch_deg": 0}}}, "no variable 'pich_deg'"),
        ({"cameras": {**CAMERAS, "match": {"focal_length_mm": {"hfov": 80}}}}, "derives no 'hfov'"),
        ({"cameras": {**CAMERAS, "match": {"focal_length_mm": {"hfov_deg": 179}}}}, "is not 179 for any"),
        ({"cameras": {**CAMERAS, "match": {"zoom": {"hfov_deg": 80}}}}, "no variable 'zoom'"),
        ({"cameras": {"parts": ["IMX432"]}}, "an order needs two cameras"),
    ],
)
def test_what_cannot_be_ranked_is_refused(study, toys, tmp_path, changed, said):
    with pytest.raises(UserError) as raised:
        run(asked(study, **changed), out=tmp_path / "out", plugins=toys)
    assert said in str(raised.value)


class TestRankAgreement(ProcedureConformance):
    component = RankAgreement
    files = ("report.html", "table.csv", "scores.jsonl")

    @pytest.fixture(autouse=True)
    def _on_a_toy(self, study, toys):
        self.config = asked(study, lights={"day": {}}, scenes=2).settings  # type: ignore[misc]
        self.plugins = toys

    def comparable(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        return {name: value for name, value in super().comparable(result).items() if name != "cost"}
