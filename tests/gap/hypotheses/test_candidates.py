"""Which effects a diagnosis considers, and what becomes of those that fail."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import pytest

from tacos_framework.components import Component
from tacos_framework.contracts import LookAlike, ShownBy, Stage
from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings, setting
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.captures import CaptureFolder
from tacos_gap.captures.coverage import (
    beyond_even_fields,
    beyond_one_time,
    beyond_own_edges,
    beyond_own_levels,
    untold,
)
from tacos_gap.hypotheses.ambiguity import confused_with
from tacos_gap.hypotheses.candidates import Candidates, candidates
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_plugins.effects.motion_blur import MotionBlur
from tests.gap.small_captures import BLACK_DN, bench, capture, placed, taken


class Dimming:
    """Takes light away."""

    class Config(Settings):
        share: float = setting(0.0, help="Share of the light.", ge=0, le=1)

    stage: ClassVar[Stage] = "optics"
    neutral: ClassVar[Mapping[str, Any]] = {"share": 0.0}
    look_alikes: ClassVar[Any] = (LookAlike("fog", lambda captures: True, "dark", "it is dark there"),)
    shown_by: ClassVar[Any] = (ShownBy(lambda captures: len(captures) > 9, "more of everything"),)

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(self, samples, *, geometry, context, rng):
        return samples * (1 - samples.dtype.type(self.config.share)) if self.config.share else samples


class Broken(Dimming):
    def on_array(self, samples, *, geometry, context, rng):
        if self.config.share:
            raise ZeroDivisionError("a defect of the toy")
        return samples


class Misshapen(Dimming):
    """Loses a row."""

    def on_array(self, samples, *, geometry, context, rng):
        return samples[:, 1:] if self.config.share else samples


class Clueless(Dimming):
    """Cannot guess."""

    @classmethod
    def guesses_from(cls, captures):
        raise KeyError("no such capture")


class Undecided(Dimming):
    """Cannot say what it looks like."""

    look_alikes: ClassVar[Any] = (LookAlike("read-noise", lambda captures: captures[99], "dark", "why not"),)


class Demanding(Dimming):
    """Has a setting without a default."""

    class Config(Settings):
        share: float = setting(help="Share of the light.")


class Controlling(Dimming):
    """Is no flaw, and says so."""

    initial_guesses: ClassVar[Any] = ()


@hookimpl
def tacos_components() -> list[Component]:
    classes = (Dimming, Demanding, Controlling)
    return [
        Component("effect", cls.__name__.lower(), f"{__name__}:{cls.__name__}", summary="A toy.")
        for cls in classes
    ]


class Toys:
    """A plugin with effects as strangers write them."""

    tacos_components = staticmethod(hookimpl(lambda: tacos_components()))


@pytest.fixture(scope="module")
def plugins() -> Plugins:
    plugins = Plugins.discover()
    plugins.register(Toys(), "toys")
    return plugins


def read_noise(plugins: Plugins) -> type[Any]:
    return plugins.resolve("effect.read-noise")


def test_every_installed_effect_is_considered_that_can_be_built_and_guessed(plugins):
    found = candidates(plugins, ("jpeg",))
    assert {"dimming", "vignetting"} <= set(found.effects)
    assert not {"jpeg", "demanding", "controlling"} & set(found.effects)
    (said,) = found.limitations
    assert said.startswith("effect.demanding is not considered, since it fails.")
    assert "share" in said


def test_an_effect_that_is_not_there_cannot_be_left_out(plugins):
    with pytest.raises(UserError, match="no effect is called vigneting"):
        candidates(plugins, ("vigneting",))


@pytest.mark.parametrize(
    ("cls", "why"),
    [
        (Broken, "ZeroDivisionError: a defect of the toy"),
        (
            Misshapen,
            "ContractBroken: effect.toy gives an array of the shape (1, 119, 160, 1)",
        ),
        (Clueless, "KeyError: 'no such capture'"),
        (Undecided, "IndexError: tuple index out of range"),
    ],
)
def test_an_effect_that_raises_is_left_out_by_name_and_the_diagnosis_goes_on(cls, why, plugins):
    noise = read_noise(plugins)
    captures = taken(bench(), [placed("read-noise", noise, sigma_dn=2.0)])
    considered = Candidates({"toy": cls, "read-noise": noise}, {"toy": "acme-effects"})
    found = diagnose(CaptureFolder(Path("captures"), tuple(captures)), considered, seed=3)
    assert [cause.effect for cause in found.causes] == ["read-noise"]
    said = f"effect.toy of acme-effects is not considered, since it fails. {why}"
    assert len([text for text in found.limitations if text.startswith(said)]) == 1


def test_an_error_that_is_nobody_s_effect_is_raised(plugins, monkeypatch):
    monkeypatch.setattr("tacos_gap.answer.diagnosis.locate", lambda *given: 1 / 0)
    captures = taken([capture("dark", "dark", BLACK_DN)])
    with pytest.raises(ZeroDivisionError):
        diagnose(CaptureFolder(Path("captures"), tuple(captures)), {"dimming": Dimming})


def test_look_alikes_that_a_stranger_declares_hold_both_ways():
    effects = {"dimming": Dimming, "fog": Broken}
    assert confused_with("dimming", effects, [])["fog"].kind == "dark"
    assert confused_with("fog", effects, [])["dimming"].why == "it is dark there"
    assert confused_with("haze", effects, []) == {}


def test_what_a_stranger_needs_is_said_with_who_needs_it():
    captures = [capture("dark", "dark", BLACK_DN)]
    assert untold(captures, {"dimming": Dimming, "fog": Broken}) == {"more of everything": ["dimming", "fog"]}
    assert untold(captures * 10, {"dimming": Dimming}) == {}


def test_pictures_of_nothing_but_edges_are_not_asked_for_light_tone_and_place(plugins):
    edge = replace(capture("edge", "edge", 100.0), own_edges=True)
    dark, simulated = capture("dark", "dark", BLACK_DN), capture("flat", "flat", 100.0)
    effects = candidates(plugins).effects
    beyond = beyond_own_edges([edge, dark], effects)
    assert beyond >= {"nonlinearity", "vignetting", "veiling-glare", "exposure-error", "pose-error"}
    assert beyond.isdisjoint({"defocus", "lens-blur", "motion-blur", "sharpening", "jpeg"})
    assert beyond_own_edges([edge, simulated], effects) == set()
    assert beyond_own_edges([dark], effects) == set()
    left = Candidates(effects).without_these(beyond, "Edges")
    assert set(left.effects) == set(effects) - beyond
    assert left.limitations[0].startswith("Edges cannot show ")
    assert "vignetting" in left.limitations[0]
    assert Candidates(effects).without_these(set(), "Edges").limitations == ()


def test_even_fields_are_not_asked_where_things_are(plugins):
    """Of a mosaic's colours a camera turned by twenty degrees would see others, as if the level were off."""
    flat, dark, scene = (capture(kind, kind, 100.0) for kind in ("flat", "dark", "scene"))
    effects = candidates(plugins).effects
    beyond = beyond_even_fields([flat, dark], effects)
    assert beyond == {"pose-error", "lens-distortion", "focal-length-error", "rolling-shutter"}
    assert beyond_even_fields([flat, scene], effects) == set()
    assert beyond_even_fields([flat, capture("board", "board", 100.0)], effects) == set()


def test_pictures_that_are_their_own_light_are_not_asked_how_bright_they_should_be(plugins):
    wall = replace(capture("wall", "flat", 100.0), own_level=True)
    dark, edge = capture("dark", "dark", BLACK_DN), replace(capture("edge", "edge", 100.0), own_edges=True)
    effects = candidates(plugins).effects
    assert beyond_own_levels([wall, edge, dark], effects) == {"exposure-error", "veiling-glare"}
    assert beyond_own_levels([wall, capture("chart", "chart", 100.0)], effects) == set()
    assert beyond_own_levels([dark], effects) == set()


def test_captures_of_one_time_are_not_asked_what_grows_with_time(plugins):
    chart, dark = capture("chart", "chart", 100.0), capture("dark", "dark", BLACK_DN)
    longer = replace(chart, context=replace(chart.context, exposure_s=2 * chart.context.exposure_s))
    effects = candidates(plugins).effects
    assert beyond_one_time([chart], effects) == {"dark-current"}
    assert beyond_one_time([chart, replace(longer, exposure_stated=False)], effects) == {"dark-current"}
    assert beyond_one_time([chart, longer], effects) == set()
    assert beyond_one_time([chart, dark], effects) == set()
    assert beyond_one_time([replace(dark, exposure_stated=False)], effects) == {"dark-current"}


def test_an_angle_is_given_from_zero_on():
    """A path of a shake has no sense: half a turn is the same, and a search may end anywhere."""
    term = HypothesisTerm("motion-blur", MotionBlur, {"length_px": 9.0, "angle_deg": -202.5}, {})
    assert term.settings == {"length_px": 9.0, "angle_deg": 157.5}
