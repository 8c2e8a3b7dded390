"""Each suite finds what is wrong with a component that breaks its contract."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from pydantic import BaseModel

from tacos_framework.settings import Settings, setting
from tacos_framework.testing import (
    EffectConformance,
    ExecutorConformance,
    OptimizerConformance,
    RigConformance,
    SensorConformance,
    TaskConformance,
    TrainableConformance,
)
from tacos_framework.testing.component import check_settings
from tacos_plugins.effects.vignetting import Vignetting
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.optimizers.genetic import Genetic
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.rigs.monocular import MonocularRig
from tacos_plugins.sensors.affine_noise import AffineNoise
from tacos_plugins.tasks.obstacle_visibility import ObstacleVisibility

MONOCULAR = {"focal_length_mm": 2.0, "sensor": {"width_px": 64, "height_px": 48, "pixel_um": 3.0}}


class UnseededSensor(AffineNoise):
    def expose(self, capture, *, exposure, rng, effects):
        return super().expose(capture, exposure=exposure, rng=np.random.default_rng(), effects=effects)


class DarkeningSensor(AffineNoise):
    def expose(self, capture, *, exposure, rng, effects):
        exposure = replace(exposure, time_s=1e-3 / exposure.time_s)
        return super().expose(capture, exposure=exposure, rng=rng, effects=effects)


class SensorWithoutReadout(AffineNoise):
    def _read_out(self, view, samples_dn, effects):
        return super()._read_out(view, samples_dn, type("Skip", (), {"readout": staticmethod(lambda s: s)}))


class WritingSensor(AffineNoise):
    def expose(self, capture, *, exposure, rng, effects):
        light = capture.views[0].luminance_cd_m2.base  # gets around the read-only view
        light *= 0.5
        return super().expose(capture, exposure=exposure, rng=rng, effects=effects)


class LeakyVignetting(Vignetting):
    """Never quite off."""

    def apply(self, image, *, rig, exposure, rng):
        views = (replace(view, luminance_cd_m2=view.luminance_cd_m2 * 1.001) for view in image.views)
        return super().apply(replace(image, views=tuple(views)), rig=rig, exposure=exposure, rng=rng)


class BoundlessVignetting(Vignetting):
    class Config(Settings):
        k1: float = setting(0.0, help="Coefficient of r^2.")
        k2: float = setting(0.0, help="Coefficient of r^4.", ge=0)
        k3: float = setting(0.0, help="Coefficient of r^6.", ge=0, le=1)


class JumpyVignetting(Vignetting):
    """Takes away a tenth of the light as soon as it is on."""

    def on_array(self, signal, **supplied):
        dimmed = super().on_array(signal, **supplied)
        return signal if dimmed is signal else dimmed * np.float32(0.9)


class CopyingVignetting(Vignetting):
    def on_array(self, signal, **supplied):
        return super().on_array(signal, **supplied).copy()


class TwofoldVignetting(Vignetting):
    """Does not do to arrays what it does to captures."""

    def on_array(self, signal, **supplied):
        return super().on_array(super().on_array(signal, **supplied), **supplied)

    def apply(self, image, *, rig, exposure, rng):
        return Vignetting(self.config).apply(image, rig=rig, exposure=exposure, rng=rng)


class WideningVignetting(Vignetting):
    def on_array(self, signal, **supplied):
        return super().on_array(signal, **supplied).astype(np.float64)


class MisplacedVignetting(Vignetting):
    stage = "codec"


class VisibleVignetting(EffectConformance):
    """The suite at values where vignetting can be seen."""

    config: ClassVar = {"k1": -0.4}


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
        return super()._first_generation() if self._told == 0 else []


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
    (SensorConformance, UnseededSensor, "test_equal_generators_give_equal_images"),
    (SensorConformance, DarkeningSensor, "test_more_light_gives_brighter_images"),
    (SensorConformance, SensorWithoutReadout, "test_what_effects_return_reaches_the_image"),
    (SensorConformance, SensorWithoutReadout, "test_it_calls_the_effects_of_each_view_in_order"),
    (SensorConformance, WritingSensor, "test_it_leaves_the_capture_as_it_was"),
    (EffectConformance, LeakyVignetting, "test_it_is_exactly_off_at_its_neutral_values"),
    (EffectConformance, MisnamedNeutral, "test_its_neutral_values_are_settings"),
    (EffectConformance, BoundlessVignetting, "test_its_parameters_are_bounded_on_both_sides"),
    (VisibleVignetting, JumpyVignetting, "test_it_vanishes_as_its_parameters_near_the_neutral_values"),
    (VisibleVignetting, CopyingVignetting, "test_arrays_pass_unchanged_at_its_neutral_values"),
    (VisibleVignetting, TwofoldVignetting, "test_on_arrays_it_does_what_it_does_to_an_image"),
    (VisibleVignetting, MisplacedVignetting, "test_its_stage_fits_the_image_it_takes"),
    (EffectConformance, Vignetting, "test_it_changes_the_image_at_other_values"),  # config left neutral
    (OptimizerConformance, ForgetfulSearch, "test_resumed_after_any_round_it_goes_on_as_if_never_stopped"),
    (OptimizerConformance, HastySearch, "test_a_state_taken_before_the_results_are_told_asks_again"),
    (OptimizerConformance, EndlessSearch, "test_it_says_why_it_stops"),
    (OptimizerConformance, FragileGenetic, "test_it_goes_on_when_every_candidate_fails"),
    (ExecutorConformance, ShufflingExecutor, "test_results_are_those_of_plain_calls_in_order"),
    (RigConformance, NamelessRig, "test_it_derives_the_quantities_it_names"),
    (TaskConformance, ForgetfulTask, "test_batches_may_be_cut_anywhere"),
    (TaskConformance, InfiniteTask, "test_its_scores_are_named_and_finite"),
    (TrainableConformance, LearningTask, "test_training_moves_the_state_and_leaves_the_old_one"),
]


def bound(suite, component):
    """The suite of a component, as a plugin author would write it."""
    return type("TestIt", (suite,), {"component": component, "variables": MONOCULAR})()


@pytest.mark.parametrize(("suite", "component", "test"), FAULTS)
def test_a_fault_is_found(suite, component, test):
    bound_suite = bound(suite, component)
    arguments = [bound_suite.make()] if suite is ExecutorConformance else []
    with pytest.raises(AssertionError):
        getattr(bound_suite, test)(*arguments)


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
