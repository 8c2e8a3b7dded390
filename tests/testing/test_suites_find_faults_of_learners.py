"""Faults of tasks that learn and of procedures: in states, files and results."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tacos_framework.settings import Settings
from tacos_framework.testing import (
    ProcedureConformance,
    TrainableConformance,
)
from tests.testing.applied_suite import apply, faults_are_found, sound_ones_pass
from tests.toy_plugin import Learner

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
    (TrainableConformance, Learner),
    (ProcedureConformance, SoundProcedure),
]


test_a_fault_is_found = faults_are_found(FAULTS)


def test_results_that_are_no_json_are_found(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        apply(ProcedureConformance, NanProcedure, "test_its_result_is_json_with_a_summary", tmp_path)


test_sound_components_pass_what_the_faulty_ones_fail = sound_ones_pass(SOUND, FAULTS)
