"""What a class lacks to be a component is said when it resolves, in a sentence for each thing."""

from __future__ import annotations

from typing import Any

import pytest

from tacos_framework.components import Component
from tacos_framework.contracts import BASES, optional
from tacos_framework.plugins.contract_check import unread_members
from tacos_framework.values import Capture, Episode, FrameBatch
from tests.plugins.sound_classes import SOUND, SoundScorer, changed, faults


@pytest.mark.parametrize("kind", SOUND)
def test_sound_classes_have_none(kind):
    assert faults(kind, SOUND[kind]) == []


@pytest.mark.parametrize(
    ("kind", "members"),
    [
        ("optimizer", {"__init__": lambda self, config, *, space, rng, problem: None}),
        ("optimizer", {"__init__": lambda self, config, space, rng, problem=None: None}),
        ("optimizer", {"recommend": lambda self, count: []}),
        ("rig", {"coordinates": lambda self, variables: {}}),
        ("task", {"score_scales": {"inliers": "count"}, "depends_on": {"inliers": ("hfov_deg",)}}),
    ],
)
def test_what_is_optional_may_be_there(kind, members):
    assert changed(kind, **members) == []


def test_what_is_no_class_is_none():
    assert faults("task", len) == ["mine:Mine is a builtin_function_or_method, not a class"]


def test_an_effect_needs_on_array_or_source():
    expected = [
        "Mine has no method on_array, which changes the samples of one camera, "
        "nor source in its place, for an effect that only moves pixels"
    ]
    assert changed("effect", on_array=None) == expected
    assert changed("effect", on_array=None, source=lambda self, *, geometry, context, frames: None) == []


@pytest.mark.parametrize(
    ("kind", "members", "fault"),
    [
        (
            "effect",
            {"stage": "optic"},
            "Mine.stage is 'optic', not one of scene, optics, exposure, pixel, readout, isp, codec. "
            "Did you mean 'optics'?",
        ),
        (
            "effect",
            {"neutral": {"blur": 0}},
            "Mine.neutral has 'blur', which is no setting. Did you mean 'blur_px'?",
        ),
        (
            "effect",
            {"neutral": ["blur_px"]},
            "Mine.neutral is ['blur_px'], not a mapping of settings to the values that switch it off",
        ),
        ("effect", {"rank": "first"}, "Mine.rank is 'first', not a whole number"),
        (
            "task",
            {"scores": ["inliers"]},
            "Mine.scores is ['inliers'], not a tuple of names such as ('inliers',)",
        ),
        ("task", {"scores": ()}, "Mine.scores is (), not a tuple of names such as ('inliers',)"),
        (
            "task",
            {"scores": "inliers"},
            "Mine.scores is 'inliers', not a tuple of names such as ('inliers',)",
        ),
        (
            "task",
            {"lower_is_better": True},
            "Mine.lower_is_better is True, not a set of names such as {'error_px'}",
        ),
        (
            "task",
            {"lower_is_better": frozenset({"inlier"})},
            "Mine.lower_is_better has 'inlier', which is no score of it. Did you mean 'inliers'?",
        ),
        ("task", {"Training": dict}, "Mine.Training is not a tacos_framework.settings.Settings class"),
        ("rig", {"Variables": dict}, "Mine.Variables is not a tacos_framework.settings.Settings class"),
        (
            "rig",
            {"derived_quantities": {"hfov_deg": 1}},
            "Mine.derived_quantities is no mapping of names to units, such as {'hfov_deg': 'deg'}",
        ),
    ],
)
def test_class_attributes_must_be_what_they_are_for(kind, members, fault):
    assert changed(kind, **members) == [fault]


def no_type(self, episode, *, rig) -> Capture: ...
def no_output(self, episode: Episode, *, rig): ...
def by_position(self, episode: Episode, rig: Any) -> Capture: ...
def any_ports(self, *episodes: Episode) -> Capture: ...
def asks_for_more(self, episode: Episode, *, rigg) -> Capture: ...
def asks_with_default(self, episode: Episode, *, quality: int = 3) -> Capture: ...
def unknown_type(self, episode: Elsewhere) -> Capture: ...  # noqa: F821 - that is the point


@pytest.mark.parametrize(
    ("verb", "fault"),
    [
        (no_type, "Mine.capture: port 'episode' has no type annotation"),
        (no_output, "Mine.capture does not say what it gives: annotate it with a type"),
        (by_position, "Mine.capture: 'rig' is supplied by keyword, and no port: put it behind a *"),
        (any_ports, "Mine.capture: 'episodes' stands for any ports; each needs a name and a type"),
        (
            asks_for_more,
            "Mine.capture asks for 'rigg', which the framework does not supply: rig, exposure, rng, "
            "illumination_lux can be had by keyword. Did you mean 'rig'?",
        ),
        (
            unknown_type,
            "Mine.capture: its annotations cannot be read: NameError: name 'Elsewhere' is not defined",
        ),
    ],
)
def test_verbs_of_nodes_have_typed_ports_and_ask_for_what_there_is(verb, fault):
    assert changed("renderer", capture=verb) == [fault]


def test_keywords_with_a_default_are_ones_own_affair():
    assert changed("renderer", capture=asks_with_default) == []


@pytest.mark.parametrize(
    ("kind", "members", "fault"),
    [
        ("task", {"begin": None}, "Mine has no method begin"),
        (
            "effect",
            {"on_array": lambda self, samples, *, geometry, rng: samples},
            "Mine.on_array does not take 'context', with which the framework calls it",
        ),
        (
            "effect",
            {"on_array": lambda self, samples, strength, *, geometry, context, rng: samples},
            "Mine.on_array needs 'strength', which it is not given: it is called with samples",
        ),
        (
            "executor",
            {"map": lambda self, jobs: jobs},
            "Mine.map takes 1 arguments by position, but is called with evaluate, jobs",
        ),
        (
            "optimizer",
            {"__init__": lambda self, config, space: None},
            "Mine does not take 'rng', with which the framework calls it",
        ),
        (
            "optimizer",
            {"tell": lambda self: None},
            "Mine.tell takes 0 arguments by position, but is called with evaluated",
        ),
        (
            "optimizer",
            {"__init__": lambda self, config, *, space, rng, problems: None},
            "Mine asks for 'problems', which the framework does not supply: "
            "space, rng, problem can be had by keyword. Did you mean 'problem'?",
        ),
        (
            "optimizer",
            {"recommend": lambda self: []},
            "Mine.recommend takes 0 arguments by position, but is called with count",
        ),
        (
            "rig",
            {"coordinates": lambda self: {}},
            "Mine.coordinates takes 0 arguments by position, but is called with variables",
        ),
        (
            "task",
            {"score_scales": {"inlier": "count"}},
            "Mine.score_scales is {'inlier': 'count'}, not a mapping with scores of it as keys",
        ),
        (
            "task",
            {"score_scales": {"inliers": "counts"}},
            "Mine.score_scales has 'counts' for 'inliers', not one of real, count, share",
        ),
        (
            "task",
            {"depends_on": {"inliers": "hfov_deg"}},
            "Mine.depends_on has 'hfov_deg' for 'inliers', not a tuple of names of coordinates",
        ),
        (
            "rig",
            {"__init__": lambda self, config, room: None},
            "Mine needs 'room', which it is not given: it is called with config",
        ),
        (
            "rig",
            {"__init__": object.__init__},
            "Mine has no __init__, so that it cannot be built with its settings",
        ),
    ],
)
def test_other_verbs_can_be_called_with_exactly_what_the_framework_gives(kind, members, fault):
    assert changed(kind, **members) == [fault]


def test_a_static_method_is_no_worse():
    assert changed("executor", map=staticmethod(lambda evaluate, jobs: jobs)) == []


class NoScores:
    def update(self, frames: FrameBatch) -> None: ...


class NoPort(SoundScorer):
    def update(self, frames) -> None: ...


def begin_untyped(self, *, state): ...
def begin_without_scores(self, *, state) -> NoScores: ...
def begin_without_port(self, *, state) -> NoPort: ...


@pytest.mark.parametrize(
    ("begin", "fault"),
    [
        (begin_untyped, "Mine.begin does not say what it returns: annotate it with the class of the scorer"),
        (begin_without_scores, "Mine.begin is annotated to return NoScores, which has no method scores"),
        (begin_without_port, "NoPort.update: port 'frames' has no type annotation"),
    ],
)
def test_a_task_says_what_scores_for_it(begin, fault):
    assert changed("task", begin=begin) == [fault]


def test_a_task_that_learns_is_called_to_fit():
    fit = {"fit": lambda self, batches, *, state, rng: state, "initial_state": lambda self, *, rng: {}}
    assert changed("task", **fit) == ["Mine.fit does not take 'budget', with which the framework calls it"]


@pytest.mark.parametrize(
    ("kind", "member", "meant"),
    [
        ("effect", "initial_gueses", "initial_guesses"),
        ("effect", "after_nois", "after_noise"),
        ("effect", "look_alike", "look_alikes"),
        ("optimizer", "recomend", "recommend"),
        ("optimizer", "budgets", "budget"),
        ("task", "lower_is_beter", "lower_is_better"),
        ("task", "margin", "margins"),
        ("rig", "coordinate", "coordinates"),
        ("renderer", "averages_exposures", "averages_exposure"),
        ("executor", "worker", "workers"),
    ],
)
def test_a_misspelt_optional_member_is_a_fault(kind, member, meant):
    assert changed(kind, **{member: ()}) == [
        f"Mine.{member} is no member of the contract. Did you mean {meant!r}?"
    ]


def test_every_misspelt_member_is_named():
    assert len(changed("effect", initial_gueses=(), after_nois=True, shownby=())) == 3
    assert len(changed("optimizer", recomend=len, chose=len)) == 2


def test_a_helper_is_no_fault_and_is_listed():
    helped = type("Mine", (SOUND["effect"],), {"kernel_of": lambda self: None, "_own": 1})
    assert faults("effect", helped) == []
    assert unread_members(Component("effect", "mine", "x:Mine", summary="."), helped) == ["kernel_of"]


@pytest.mark.parametrize("kind", sorted(BASES))
def test_optional_members_can_be_read_of_any_component_and_no_others(kind):
    base = BASES[kind]
    names = [name for name in vars(base) if not name.startswith("_")]
    assert names
    for name in names:
        assert optional(object(), base, name) == getattr(base, name)
    with pytest.raises(AttributeError, match="initial_gueses"):
        optional(object(), base, "initial_gueses")
