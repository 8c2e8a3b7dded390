"""Executors that mix up results: order is put right, the rest are errors that name them."""

from __future__ import annotations

import random

import pytest
from toy_study import LEARNER, comparable, merged, run, toy_recipe

from tacos_framework.errors import ContractBroken


class Shuffling:
    """Hands results on in any order; says it has workers, so that work is cut up."""

    workers = 3

    def __init__(self):
        self.rng = random.Random(5)

    def map(self, evaluate, jobs):
        results = [evaluate(job) for job in jobs]
        self.rng.shuffle(results)
        return iter(results)


class Dropping:
    """Loses the result of the last of several jobs."""

    def map(self, evaluate, jobs):
        return map(evaluate, jobs[: max(1, len(jobs) - 1)])


STUDIES = {
    "plain": {},
    "blocks": {"study": {"blocks": 5}},
    "shared": LEARNER,
    "branched": merged(LEARNER, {"nodes": {"learner": {"train": {"weights": "branched"}}}}),
    "best": merged(LEARNER, {"study": {"train_best": 2}}),
}


@pytest.mark.parametrize("sections", STUDIES.values(), ids=STUDIES)
def test_the_order_of_results_changes_no_study(toys, tmp_path, sections):
    compared = {
        "compare": {"cameras": ["flea3", "oak_d_pro_wide"], "evaluations": 4},
        "rig": {"binning": 200},
    }
    recipe = toy_recipe(**merged(sections, compared))
    shuffled = run(recipe, toys, tmp_path / "shuffled", executor=Shuffling())
    assert comparable(shuffled) == comparable(run(recipe, toys, tmp_path / "local"))


def test_a_result_that_is_missing_ends_the_study_and_names_the_executor(toys, tmp_path):
    with pytest.raises(ContractBroken, match="the executor Dropping gives no result for 1 of 6 jobs: 6"):
        run(toy_recipe(), toys, tmp_path, executor=Dropping())
