"""Each suite finds what is wrong with a component that breaks its contract."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
import pytest
from pydantic import BaseModel

from tacos_framework.settings import Settings, physical, setting
from tacos_framework.testing import (
    EffectConformance,
    ExecutorConformance,
    OptimizerConformance,
    RigConformance,
    TaskConformance,
    TrainableConformance,
)
from tacos_framework.testing.component import check_settings
from tacos_plugins.effects.vignetting import Vignetting
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.optimizers.genetic import Genetic
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.tasks.obstacle_visibility import ObstacleVisibility
from tests.testing.applied_suite import bound, faults_are_found


class LeakyVignetting(Vignetting):
    """Never quite off."""

    def on_array(self, samples, **supplied):
        return super().on_array(samples, **supplied) * np.float32(1.001)


class BoundlessVignetting(Vignetting):
    class Config(Settings):
        k1: float = setting(0.0, help="Coefficient of r^2.")
        k2: float = setting(0.0, help="Coefficient of r^4.", ge=0)
        k3: float = setting(0.0, help="Coefficient of r^6.", ge=0, le=1)


class JumpyVignetting(Vignetting):
    """Takes away a tenth of the light as soon as it is on."""

    def on_array(self, samples, **supplied):
        dimmed = super().on_array(samples, **supplied)
        return samples if dimmed is samples else dimmed * np.float32(0.9)


class CopyingVignetting(Vignetting):
    def on_array(self, samples, **supplied):
        return super().on_array(samples, **supplied).copy()


class ScribblingVignetting(Vignetting):
    def on_array(self, samples, **supplied):
        samples *= np.float32(0.5)
        return super().on_array(samples, **supplied)


class RestlessVignetting(Vignetting):
    """Draws from a generator of its own."""

    def on_array(self, samples, **supplied):
        dimmed = super().on_array(samples, **supplied)
        return dimmed * np.float32(np.random.default_rng().uniform(0.5, 1.0))


class TwofacedVignetting(Vignetting):
    """Both an effect on arrays and one that moves pixels."""

    def source(self, *, geometry, context, frames):
        return None


class WideningVignetting(Vignetting):
    def on_array(self, samples, **supplied):
        return super().on_array(samples, **supplied).astype(np.float64)


class MisplacedVignetting(Vignetting):
    stage = "lens"


class VisibleVignetting(EffectConformance):
    """The suite at values where vignetting can be seen."""

    config: ClassVar = {"k1": -0.4}


class MisnamedPhysical(Vignetting):
    class Config(Vignetting.Config):
        k0_um: float | None = physical("k0_px", help="Stands for nothing.", unit="um")


class MisnamedNeutral(Vignetting):
    neutral: ClassVar = {"k0": 0.0}


class ForgetfulSearch(RandomSearch):
    """Resumes with another generator."""

    def restore(self, state):
        super().restore({**state, "rng": np.random.default_rng(99).bit_generator.state})


class HastySearch(RandomSearch):
    """Draws anew at every call of ask."""

    def ask(self):
        self._asked = self._next()
        return super().ask()

    def state(self):
        return {**super().state(), "asked": []}


class EndlessSearch(RandomSearch):
    def stop(self):
        return None


class FragileGenetic(Genetic):
    """Has nothing to ask once all have failed."""

    def _first_generation(self):
        return super()._first_generation() if self._generations_observed == 0 else []


class ShufflingExecutor(LocalExecutor):
    def map(self, evaluate, jobs):
        return super().map(evaluate, list(jobs)[::-1])


class WrappingExecutor(LocalExecutor):
    def map(self, evaluate, jobs):
        def wrapped(job):
            try:
                return evaluate(job)
            except Exception as error:
                raise RuntimeError("a job failed") from error

        return super().map(wrapped, jobs)


class NamelessRig(MonocularRig):
    derived_quantities: ClassVar = {"hfov_deg": "deg"}


class ForgetfulTask(ObstacleVisibility):
    """Scores only its last batch."""

    def begin(self, *, state=None):
        scorer = super().begin(state=state)
        take_in = scorer.update

        def update(frames):
            scorer._walks.clear()
            take_in(frames)

        scorer.update = update
        return scorer


class InfiniteTask(ObstacleVisibility):
    def begin(self, *, state=None):
        scorer = super().begin(state=state)
        scorer.scores = lambda: {"seen_ratio": math.inf}
        return scorer


class LearningTask(ObstacleVisibility):
    def initial_state(self, *, rng):
        return {"weights": rng.random(3)}

    def fit(self, batches, *, state, budget, rng):
        state["weights"] += 1.0  # where it should give a new state
        return state


FAULTS = [
    (VisibleVignetting, LeakyVignetting, "test_it_is_exactly_off_at_its_neutral_values"),
    (EffectConformance, MisnamedNeutral, "test_it_names_settings_alone"),
    (EffectConformance, MisnamedPhysical, "test_its_physical_settings_stand_for_others"),
    (EffectConformance, BoundlessVignetting, "test_its_parameters_are_bounded_on_both_sides"),
    (VisibleVignetting, JumpyVignetting, "test_it_vanishes_as_its_parameters_near_the_neutral_values"),
    (VisibleVignetting, CopyingVignetting, "test_it_is_exactly_off_at_its_neutral_values"),
    (VisibleVignetting, CopyingVignetting, "test_off_it_hands_images_on_without_a_copy"),
    (VisibleVignetting, ScribblingVignetting, "test_it_leaves_its_input_as_it_was"),
    (VisibleVignetting, RestlessVignetting, "test_equal_generators_give_equal_images"),
    (VisibleVignetting, TwofacedVignetting, "test_it_is_written_on_arrays_or_says_where_pixels_come_from"),
    (VisibleVignetting, MisplacedVignetting, "test_its_stage_is_one_of_image_formation"),
    (EffectConformance, Vignetting, "test_it_changes_the_image_at_other_values"),  # config left neutral
    (EffectConformance, Vignetting, "test_it_acts_in_image_formation"),
    (OptimizerConformance, ForgetfulSearch, "test_resumed_after_any_round_it_goes_on_as_if_never_stopped"),
    (OptimizerConformance, HastySearch, "test_a_state_taken_before_the_results_are_told_asks_again"),
    (OptimizerConformance, EndlessSearch, "test_it_says_why_it_stops"),
    (
        OptimizerConformance,
        FragileGenetic,
        "test_it_goes_on_when_it_is_told_of_every_candidate[that it fails]",
    ),
    (ExecutorConformance, ShufflingExecutor, "test_results_are_those_of_plain_calls_in_order"),
    (RigConformance, NamelessRig, "test_it_derives_the_quantities_it_names"),
    (TaskConformance, ForgetfulTask, "test_batches_may_be_cut_anywhere"),
    (TaskConformance, InfiniteTask, "test_its_scores_are_named_and_finite"),
    (TrainableConformance, LearningTask, "test_training_moves_the_state_and_leaves_the_old_one"),
]


test_a_fault_is_found = faults_are_found(FAULTS)


def test_an_effect_that_changes_the_type_of_an_array_is_found():
    suite = bound(VisibleVignetting, WideningVignetting)
    with pytest.raises(AssertionError):
        suite.test_arrays_keep_shape_and_type(np.float32)


def test_a_wrapped_error_is_found():
    suite = bound(ExecutorConformance, WrappingExecutor)
    with pytest.raises(RuntimeError, match="a job failed"):
        suite.test_results_before_an_error_arrive_and_the_error_is_unchanged(suite.make())


def test_settings_must_be_documented_frozen_and_the_frameworks_own():
    class Undocumented(Settings):
        radius_px: float = 1.0

    class Documented(Settings):
        radius_px: float = setting(1.0, help="Radius.", unit="px")

    class Thawed(Documented):
        model_config: ClassVar = {"frozen": False}

    class Foreign(BaseModel):
        pass

    check_settings(Documented)
    for wrong, said in [
        (Undocumented, "radius_px has no help"),
        (Thawed, "not frozen"),
        (Foreign, "Settings"),
    ]:
        with pytest.raises(AssertionError, match=said):
            check_settings(wrong)
