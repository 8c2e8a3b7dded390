"""The diagnosis as a whole, on captures whose effect is known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from tacos_framework.plugins import Plugins
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import Diagnosis, SoFar
from tacos_gap.captures import CaptureFolder
from tests.gap.small_captures import bench, capture, effects_named, placed, taken

FEW = (
    "vignetting",
    "exposure-error",
    "defocus",
    "lens-blur",
    "read-noise",
    "prnu",
    "dsnu",
    "black-level",
    "crosstalk",
)


@pytest.fixture(scope="module")
def effects() -> dict[str, type[Any]]:
    return effects_named(*FEW)


def run(captures: list[Any], effects: dict[str, type[Any]]) -> Diagnosis:
    return diagnose(CaptureFolder(Path("captures"), tuple(captures)), effects, seed=3)


def make(effects: dict[str, type[Any]], name: str, **settings: float) -> Any:
    return placed(name, effects[name], **settings)


def test_nothing_is_found_where_nothing_is(effects):
    found = run(taken(bench()), effects)
    assert found.verdict == "no_gap"
    assert found.causes == []
    assert found.effects == []


def algebra_threads() -> set[int]:
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


def test_linear_algebra_has_one_thread_while_captures_have_theirs(effects):
    seen: list[set[int]] = []
    with threadpool_limits(2, user_api="blas"):
        before = algebra_threads()
        folder = CaptureFolder(Path("captures"), tuple(taken(bench())))
        diagnose(folder, effects, seed=3, notify=lambda text: seen.append(algebra_threads()))
        assert algebra_threads() == before
    assert seen
    assert all(each == {1} for each in seen)


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("vignetting", {"k1": -0.3}),
        ("exposure-error", {"scale": 1.08}),
        ("defocus", {"radius_px": 1.6}),
        ("read-noise", {"sigma_dn": 1.5}),
        ("dsnu", {"sigma_dn": 1.5}),
        ("black-level", {"offset_dn": 2.0}),
        ("crosstalk", {"share": 0.03}),
    ],
)
def test_a_single_effect_is_named_with_its_parameter(effects, name, settings):
    found = run(taken(bench(), [make(effects, name, **settings)]), effects)
    assert found.verdict == "explained"
    assert found.causes[0].effect == name
    assert found.causes[0].present > 0.8
    assert found.causes[0].closure > 0.8
    for parameter, value in settings.items():
        assert found.causes[0].parameters[parameter].value == pytest.approx(value, rel=0.12)
    assert found.effects[0]["use"] == f"effect.{name}"


def test_corners_that_are_brighter_than_expected_are_no_vignetting(effects):
    lifting = Plugins.discover().resolve("effect.lens-shading-correction")
    found = run(taken(bench(), [placed("lens-shading-correction", lifting, k1=0.5)]), effects)
    assert "vignetting" not in found.cause_set
    assert found.verdict in ("unknown", "partly_explained")


def test_two_effects_share_the_gap(effects):
    both = [make(effects, "vignetting", k1=-0.3), make(effects, "read-noise", sigma_dn=2.0)]
    found = run(taken(bench(), both), effects)
    assert {cause.effect for cause in found.causes} == {"vignetting", "read-noise"}
    assert sum(cause.shapley for cause in found.causes) == pytest.approx(found.closure, abs=0.02)


def test_a_search_that_was_cut_short_is_unknown_and_says_how_to_go_on(effects):
    captures = taken(bench(), [make(effects, "crosstalk", share=0.04)])
    found = diagnose(CaptureFolder(Path("captures"), tuple(captures)), effects, seed=3, simulations=1)
    assert found.verdict == "unknown"
    assert found.causes == []
    assert any("a larger `simulations`" in said for said in found.limitations)


def test_an_effect_outside_the_catalogue_is_unknown(effects):
    truth = make(effects, "crosstalk", share=0.04)
    fewer = {name: cls for name, cls in effects.items() if name != "crosstalk"}
    found = run(taken(bench(), [truth]), fewer)
    assert found.unknown.score > 0.5
    assert found.verdict in ("unknown", "partly_explained")
    assert all(not cause.is_proven for cause in found.causes)


def test_one_frame_of_one_flat_does_not_tell_the_lens_from_the_light(effects):
    more = {**effects, **effects_named("illumination-gradient")}
    flat = taken([capture("flat", "flat", 120.0, frames=1)], [make(effects, "vignetting", k1=-0.3)])
    found = run(flat, more)
    assert {"vignetting", "illumination-gradient"} <= set(found.cause_set)
    assert found.causes[0].is_proven  # one of them is there for sure
    assert {"vignetting", "illumination-gradient"} <= {found.causes[0].effect, *found.causes[0].alike}
    assert found.next_capture is not None
    assert found.next_capture.kind == "flat"
    assert "rotated" in found.next_capture.why


def test_the_same_seed_gives_the_same_diagnosis(effects):
    captures = taken(bench()[:4], [make(effects, "black-level", offset_dn=3.0)])
    assert run(captures, effects).as_data() == run(captures, effects).as_data()


def test_what_arithmetic_tells_begins_the_search_and_ends_some_of_it(effects):
    more = {**effects, **effects_named("illumination-gradient")}
    both = [make(effects, "vignetting", k1=-0.3), make(effects, "prnu", sigma=0.01)]
    captures = CaptureFolder(Path("captures"), tuple(taken(bench(), both)))
    kept: list[SoFar] = []
    found = diagnose(captures, more, seed=3, keep=kept.append)
    says = {(form.effect, form.estimate.parameter): form.says for form in found.closed_forms}
    assert says["vignetting", "k1"] == says["prnu", "sigma"] == "seen"
    assert says["illumination-gradient", "gx"] == "excluded"
    assert {cause.effect for cause in found.causes} == {"vignetting", "prnu"}
    assert "illumination-gradient" not in found.attribution.directions
    assert kept[0].closed_forms
    assert kept[0].explanation == ()
    assert {term.name for term in kept[-1].explanation} == {"vignetting", "prnu"}
    again = diagnose(captures, more, seed=3, begun=kept[-1].as_data()["explanation"])
    assert {cause.effect for cause in again.causes} == {"vignetting", "prnu"}
    assert again.problem.simulations <= found.problem.simulations
