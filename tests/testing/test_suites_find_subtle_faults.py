"""Faults that show only in a study: in worlds, in views, in what is resumed, in what is learnt."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tacos_framework.contracts import Asked
from tacos_framework.errors import UserError
from tacos_framework.settings import Settings
from tacos_framework.testing import (
    ExecutorConformance,
    OptimizerConformance,
    ProcedureConformance,
    RendererConformance,
    SceneConformance,
    TrainableConformance,
)
from tacos_framework.testing.samples import sample_episode
from tacos_framework.values import Crossing
from tacos_plugins.executors.local import LocalExecutor
from tacos_plugins.optimizers.random_search import RandomSearch
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tests.toy_plugin import Learner

# scenes -------------------------------------------------------------------------------------------------


class SoundScene:
    """The sample episode, in a world that depends on the generator."""

    class Config(Settings):
        """No settings."""

    def __init__(self, config):
        pass

    def episode(self, *, rng, illumination_lux):
        episode = sample_episode(frames=4, brightness=illumination_lux / 20)
        return replace(episode, world=replace(episode.world, key=f"{rng.integers(2**32)} {illumination_lux}"))


class UnseededScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        return super().episode(rng=np.random.default_rng(), illumination_lux=illumination_lux)


class SameKeyScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        return replace(episode, world=replace(episode.world, key="always"))


class HeadstandScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        flipped = episode.trajectory.world_from_agent @ np.diag([1.0, -1.0, -1.0, 1.0])
        return replace(episode, trajectory=replace(episode.trajectory, world_from_agent=flipped))


class DarkLampScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        lights = tuple(replace(light, flux_lm=-light.flux_lm) for light in episode.world.lights)
        return replace(episode, world=replace(episode.world, lights=lights))


class BackgroundCrossingScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        return replace(episode, crossings=(Crossing(0, 0.1),))


# renderers ----------------------------------------------------------------------------------------------


class ChangedViews(AnalyticRenderer):
    """Hands on the views of a sound renderer, changed."""

    def capture(self, episode, *, rig, exposure):
        capture = super().capture(episode, rig=rig, exposure=exposure)
        return replace(capture, views=tuple(self.changed(view, exposure) for view in capture.views))

    def changed(self, view, exposure):
        return view


class RayLengthRenderer(ChangedViews):
    def changed(self, view, exposure):
        x = (np.arange(view.camera.width_px) - view.camera.centre_px[0]) / view.camera.focal_length_px
        return replace(view, depth_m=view.depth_m * np.hypot(1, x).astype(np.float32))


class GammaRenderer(ChangedViews):
    def changed(self, view, exposure):
        return replace(view, luminance_cd_m2=np.sqrt(view.luminance_cd_m2))


class ShiftedIdsRenderer(ChangedViews):
    def changed(self, view, exposure):
        return replace(view, object_id=np.roll(view.object_id, 9, axis=2))


class NoisyRenderer(ChangedViews):
    def changed(self, view, exposure):
        noise = np.random.default_rng().random(view.luminance_cd_m2.shape, np.float32)
        return replace(view, luminance_cd_m2=view.luminance_cd_m2 + noise)


class FadingRenderer(ChangedViews):
    """Counts frames from the beginning of the batch."""

    def changed(self, view, exposure):
        fading = 0.9 ** np.arange(len(view.depth_m), dtype=np.float32)
        return replace(view, luminance_cd_m2=view.luminance_cd_m2 * fading[:, None, None, None])


class SecretlyExposedRenderer(ChangedViews):
    def changed(self, view, exposure):
        return replace(view, luminance_cd_m2=view.luminance_cd_m2 * np.float32(exposure.gain))


# optimizers, executors -------------------------------------------------------------------------


class RestlessSearch(RandomSearch):
    def ask(self):
        return self._next()


class LiveSearch(RandomSearch):
    """Hands out the very list it goes on to fill."""

    def tell(self, evaluated):
        self.__dict__.setdefault("observed", []).append(len(evaluated))
        super().tell(evaluated)

    def state(self):
        return {**super().state(), "observed": self.__dict__.setdefault("observed", [])}


class UnderstatedSearch(RandomSearch):
    expected_candidates = 5


class RecommendingSearch(RandomSearch):
    """Recommends, and has candidates scored on one episode each, as the contract allows."""

    episodes = (2,)

    def __init__(self, config, *, space, rng, problem):
        super().__init__(config, space=space, rng=rng)
        self.problem = problem

    def ask(self):
        return [Asked(candidate, self.episodes) for candidate in super().ask()]

    def recommend(self, count):
        rng = np.random.default_rng(1)
        drawn = [self._space.sample(rng) for _ in range(20 * count)]
        return [candidate for candidate in drawn if not self.problem.broken(candidate)][:count]


class OverreachingSearch(RecommendingSearch):
    episodes = (2, 3)


class LawlessSearch(RecommendingSearch):
    """Recommends what breaks a constraint."""

    def recommend(self, count):
        return [self._space.decode([-30, 4, 1])]


class RestlessAdviser(RecommendingSearch):
    """Draws what it recommends with the generator it asks with."""

    def recommend(self, count):
        return [self._space.decode([self._rng.uniform(0, 20), 4, 1])]


class StrictSearch(RandomSearch):
    """Cannot bear a broken constraint."""

    def tell(self, evaluated):
        assert not any(result.broken for result in evaluated)
        super().tell(evaluated)


class SpreadSearch(RandomSearch):
    """Divides by the spread of the fitness."""

    def tell(self, evaluated):
        values = [result.fitness for result in evaluated if result.fitness is not None]
        assert len(values) < 2 or np.ptp(values) > 0
        super().tell(evaluated)


class FirstFaultExecutor(LocalExecutor):
    """Keeps of an error only its first fault."""

    def map(self, evaluate, jobs):
        try:
            yield from super().map(evaluate, jobs)
        except UserError as error:
            raise UserError(error.faults[0]) from None


class StickyExecutor(LocalExecutor):
    """Goes on with the first function it was given."""

    function = None

    def map(self, evaluate, jobs):
        self.function = self.function or evaluate
        return super().map(self.function, jobs)


# tasks that learn ---------------------------------------------------------------------------------------


class HoardingTask(Learner):
    """Keeps what it learnt in itself."""

    learnt = None

    def fit(self, batches, *, state, budget, rng):
        self.learnt = super().fit(batches, state=state, budget=budget, rng=rng)
        return self.learnt

    def begin(self, *, state):
        return super().begin(state=self.learnt or state)


class ForeignOrderTask(Learner):
    """Keeps numbers in the byte order of another machine, which files of weights do not."""

    def initial_state(self, *, rng):
        return {name: _swapped(array) for name, array in super().initial_state(rng=rng).items()}

    def fit(self, batches, *, state, budget, rng):
        fitted = super().fit(batches, state=state, budget=budget, rng=rng)
        return {name: _swapped(array) for name, array in fitted.items()}


def _swapped(array):
    return array.astype(array.dtype.newbyteorder(">"))


class WordyTask(Learner):
    def initial_state(self, *, rng):
        return {**super().initial_state(rng=rng), "notes": np.array(["nothing yet"])}


class ScribblingTask(Learner):
    """Counts its scorers in the state."""

    def begin(self, *, state):
        state["steps"][:] += 1
        return super().begin(state=state)


class ForgettingTask(Learner):
    def fit(self, batches, *, state, budget, rng):
        return {"mean": super().fit(batches, state=state, budget=budget, rng=rng)["mean"]}


# procedures ---------------------------------------------------------------------------------------------


class SoundProcedure:
    class Config(Settings):
        """No settings."""

    def __init__(self, config):
        pass

    def run(self, *, out: Path, seed: int) -> Mapping[str, Any]:
        (out / "found.txt").write_text(str(seed))
        return {"seed": seed, "summary": "Found."}


class SilentProcedure(SoundProcedure):
    def run(self, *, out, seed):
        return {"seed": seed}


class NanProcedure(SoundProcedure):
    def run(self, *, out, seed):
        return {"mean": float("nan"), "summary": "Nothing."}


class DemandingProcedure(SoundProcedure):
    def run(self, *, out, seed, network=None):
        return super().run(out=out, seed=seed)


class UnseededProcedure(SoundProcedure):
    def run(self, *, out, seed):
        return {"mean": float(np.random.default_rng().random()), "summary": "Random."}


class LitteringProcedure(SoundProcedure):
    def run(self, *, out, seed):
        (out.parent / "litter").touch()
        return super().run(out=out, seed=seed)


FAULTS = [
    (SceneConformance, UnseededScene, "test_equal_generators_give_equal_episodes"),
    (SceneConformance, SameKeyScene, "test_other_generators_give_other_worlds_with_other_keys"),
    (SceneConformance, SameKeyScene, "test_other_light_is_another_world"),
    (SceneConformance, HeadstandScene, "test_its_poses_are_upright_and_rigid"),
    (SceneConformance, DarkLampScene, "test_its_light_is_light"),
    (SceneConformance, BackgroundCrossingScene, "test_its_crossings_name_objects_on_the_way"),
    (RendererConformance, RayLengthRenderer, "test_it_measures_depth_along_the_optical_axis"),
    (RendererConformance, GammaRenderer, "test_twice_the_light_gives_twice_the_luminance"),
    (RendererConformance, ShiftedIdsRenderer, "test_it_names_objects_where_they_are"),
    (RendererConformance, NoisyRenderer, "test_it_repeats_itself"),
    (RendererConformance, FadingRenderer, "test_batches_may_be_cut_anywhere"),
    (
        RendererConformance,
        SecretlyExposedRenderer,
        "test_the_light_of_a_scene_does_not_depend_on_how_it_is_exposed",
    ),
    (OptimizerConformance, RestlessSearch, "test_it_asks_the_same_until_it_is_told"),
    (OptimizerConformance, LiveSearch, "test_a_state_once_taken_does_not_change"),
    (OptimizerConformance, UnderstatedSearch, "test_it_asks_for_no_more_than_it_expects"),
    (OptimizerConformance, OverreachingSearch, "test_it_asks_for_candidates_that_can_be_made"),
    (OptimizerConformance, LawlessSearch, "test_it_recommends_candidates_that_can_be_made"),
    (OptimizerConformance, RestlessAdviser, "test_a_recommendation_changes_nothing"),
    (
        OptimizerConformance,
        StrictSearch,
        "test_it_goes_on_when_it_is_told_of_every_candidate[that it breaks a constraint]",
    ),
    (
        OptimizerConformance,
        SpreadSearch,
        "test_it_goes_on_when_it_is_told_of_every_candidate[the same fitness]",
    ),
    (ExecutorConformance, FirstFaultExecutor, "test_errors_keep_what_they_carry"),
    (ExecutorConformance, StickyExecutor, "test_functions_may_change_between_calls"),
    (TrainableConformance, HoardingTask, "test_the_task_itself_learns_nothing"),
    (TrainableConformance, ForeignOrderTask, "test_its_state_survives_being_kept"),
    (TrainableConformance, WordyTask, "test_its_state_is_plain_arrays"),
    (TrainableConformance, ScribblingTask, "test_scoring_leaves_the_state_as_it_was"),
    (TrainableConformance, ForgettingTask, "test_training_keeps_names_and_shapes"),
    (ProcedureConformance, SilentProcedure, "test_its_result_is_json_with_a_summary"),
    (ProcedureConformance, SilentProcedure, "test_it_leaves_the_files_it_should"),
    (ProcedureConformance, DemandingProcedure, "test_it_asks_for_keywords_the_framework_supplies"),
    (ProcedureConformance, UnseededProcedure, "test_equal_seeds_give_equal_results"),
    (ProcedureConformance, LitteringProcedure, "test_it_writes_into_its_folder_alone"),
]
SOUND = [
    (OptimizerConformance, RecommendingSearch),
    (SceneConformance, SoundScene),
    (RendererConformance, ChangedViews),
    (TrainableConformance, Learner),
    (ProcedureConformance, SoundProcedure),
]


def apply(suite: type[Any], component: type[Any], test: str, tmp_path: Path) -> None:
    """Run one test of a suite on a component, with the fixtures it asks for."""
    bound = type("TestIt", (suite,), {"component": component, "files": ("found.txt",)})()
    offered = {
        "episode": lambda: bound.generate(),
        "renderer": bound.make,
        "executor": bound.make,
        "changes": lambda: {"gain_db": 20.0},
        "tmp_path": lambda: tmp_path,
        "told": lambda: test.removesuffix("]").partition("[")[2],
    }
    method = getattr(bound, test.partition("[")[0])
    method(**{name: offered[name]() for name in inspect.signature(method).parameters})


@pytest.mark.parametrize(("suite", "component", "test"), FAULTS)
def test_a_fault_is_found(suite: type[Any], component: type[Any], test: str, tmp_path: Path) -> None:
    with pytest.raises(AssertionError):
        apply(suite, component, test, tmp_path)


def test_results_that_are_no_json_are_found(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        apply(ProcedureConformance, NanProcedure, "test_its_result_is_json_with_a_summary", tmp_path)


@pytest.mark.parametrize(("suite", "component"), SOUND)
def test_sound_components_pass_what_the_faulty_ones_fail(
    suite: type[Any], component: type[Any], tmp_path: Path
) -> None:
    for i, test in enumerate(sorted({test for kind, _, test in FAULTS if kind is suite})):
        (tmp_path / str(i)).mkdir()
        apply(suite, component, test, tmp_path / str(i))
