"""A study whose candidates race: fewer images, the same winner, and all that holds for other studies."""

from __future__ import annotations

import json

import pytest
import toy_plugin
from toy_study import LEARNER, comparable, run, toy_recipe

from tacos_framework.errors import UserError
from tacos_framework.recipe import Recipe, parse_recipe

RACE = {"study": {"renew_episodes": "never", "blocks": 6, "race": {}}}
WHOLE = {"study": {"renew_episodes": "never", "blocks": 6}}


def candidates(folder):
    lines = (folder / "generations.jsonl").read_text().splitlines()
    return [candidate for line in lines for candidate in json.loads(line)["candidates"]]


@pytest.mark.parametrize("renew", ["never", "each_generation"])
def test_a_race_takes_fewer_images_to_the_same_winner(toys, tmp_path, renew):
    both = {}
    for name, sections in (("whole", WHOLE), ("race", RACE)):
        study = {**sections["study"], "renew_episodes": renew, "episodes": 2}
        both[name] = run(toy_recipe(study=study), toys, tmp_path / name)
    assert both["race"]["best"]["camera"] == both["whole"]["best"]["camera"]
    assert both["race"]["best"]["scores"] == both["whole"]["best"]["scores"]
    assert both["race"]["test"] == both["whole"]["test"]
    assert both["race"]["frames_rendered"] < 0.7 * both["whole"]["frames_rendered"]
    assert not any(candidate["dropped"] for candidate in candidates(tmp_path / "whole"))


def test_a_dropped_candidate_is_told_less_than_the_winner_and_never_wins(toys, tmp_path):
    result = run(toy_recipe(**RACE), toys, tmp_path / "out")
    dropped = [candidate for candidate in candidates(tmp_path / "out") if candidate["dropped"]]
    assert dropped
    assert all(candidate["fitness"] < result["best"]["fitness"] for candidate in dropped)
    assert result["best"]["camera"] not in [candidate["camera"] for candidate in dropped]


def test_the_best_before_is_a_rival_from_the_first_block(toys, tmp_path):
    """Random search asks nothing twice; still poor candidates are dropped at once in generations of one."""
    optimizer = {"use": "optimizer.random", "evaluations": 12, "batch": 1}
    recipe = Recipe.model_validate({**toy_recipe(**RACE).as_data(), "optimizer": optimizer})
    run(recipe, toys, tmp_path / "out")
    assert sum(bool(candidate["dropped"]) for candidate in candidates(tmp_path / "out")) >= 6


def test_workers_do_not_change_a_race(toys, tmp_path):
    local = run(toy_recipe(**RACE), toys, tmp_path / "local")
    two = {"executor": {"use": "executor.process", "workers": 2}}
    assert comparable(run(toy_recipe(**RACE, **two), toys, tmp_path / "two")) == comparable(local)


def test_a_race_that_was_broken_off_goes_on_as_if_it_had_not_been(toys, tmp_path):
    whole = run(toy_recipe(**RACE), toys, tmp_path / "whole")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(toy_plugin.WidthTask, "begun", 0)
        patch.setattr(toy_plugin.WidthTask, "interrupt_at", 40)
        assert run(toy_recipe(**RACE), toys, tmp_path / "broken")["stopped"] == "interrupted by the user"
    resumed = run(toy_recipe(**RACE), toys, tmp_path / "broken", resume=True)
    assert comparable(resumed) == comparable(whole)
    assert candidates(tmp_path / "broken") == candidates(tmp_path / "whole")


def test_candidates_that_fail_leave_the_race(toys, tmp_path):
    result = run(toy_recipe(nodes={"width": {"fail_above_deg": 60}}, **RACE), toys, tmp_path / "out")
    failed = [candidate for candidate in candidates(tmp_path / "out") if candidate["failed"]]
    assert failed
    assert all(candidate["fitness"] is None and candidate["dropped"] is None for candidate in failed)
    assert result["best"]["derived"]["hfov_deg"] <= 60


def test_candidates_that_learn_from_the_same_weights_race(toys, tmp_path):
    learner = {**LEARNER["nodes"]["learner"], "train": {"weights": "branched"}}
    sections = {**LEARNER, "nodes": {"learner": learner}, "study": {"blocks": 6, "race": {}}}
    result = run(toy_recipe(**sections), toys, tmp_path / "out")
    assert result["best"] is not None
    assert any(candidate["dropped"] for candidate in candidates(tmp_path / "out"))


@pytest.mark.parametrize(
    ("study", "message"),
    [
        ("{race: {}}", "before any candidate can be dropped"),
        ("{blocks: 3, race: {}}", "episodes x blocks = 1 x 3"),
        ("{blocks: 6, race: {}, common_random_numbers: false}", "common_random_numbers must be true"),
        ("{blocks: 6, race: {min_blocks: 1}}", "greater than or equal to 2"),
        ("{blocks: 6, race: {standard_error: 3}}", "Did you mean 'standard_errors'?"),
    ],
)
def test_races_that_cannot_be_run_are_refused_with_line_and_reason(study, message):
    _, faults = parse_recipe(f"tacos: 1\nname: x\nstudy: {study}\n", name="recipe.yaml")
    (fault,) = [str(fault) for fault in faults if "study" in str(fault) or "recipe.yaml:3" in str(fault)]
    assert message in fault
    assert fault.startswith("recipe.yaml:3")


def test_racing_with_shared_weights_is_refused():
    with pytest.raises(ValueError, match="learner trains with shared weights"):
        toy_recipe(**{**LEARNER, "study": {"blocks": 6, "race": {}}})


def test_more_blocks_than_frames_are_refused(toys, tmp_path):
    with pytest.raises(UserError, match="6 frames cannot be cut into 7 blocks"):
        run(toy_recipe(study={"blocks": 7}), toys, tmp_path / "out")
