"""Whether a study would decide otherwise with effects added."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from toy_study import FROM_CATALOG, LEARNER, merged

from tacos_framework import UserError
from tacos_framework.fitness import Fitness, FitnessTerm
from tacos_framework.plugins import Plugins
from tacos_framework.simulation import Evaluation
from tacos_framework.study.progress import Silent
from tacos_framework.study.sequential import compared
from tacos_framework.testing.procedure import InThisProcess
from tacos_gap.tasks.decision import Question, decide
from tacos_gap.tasks.decision.choice import choice, sentence
from tacos_gap.tasks.decision.ranked import RankedCameras, chance_best, ranked

STUDY: dict[str, Any] = {
    **FROM_CATALOG,
    "optimizer": {
        "use": "optimizer.genetic",
        "population": 4,
        "keep": 1,
        "parents": 2,
        "generations": 3,
    },
    "compare": {"cameras": ["flea3", "basler_dart"], "evaluations": 4},
    "test": {"seed": 9, "frames": 2, "episodes": 2},
}


FITNESS = Fitness((FitnessTerm("width.closeness", 1.0),))


def write(folder: Path, **changes: Any) -> Path:
    path = folder / "toy.yaml"
    path.write_text(yaml.safe_dump({key: v for key, v in {**STUDY, **changes}.items() if v is not None}))
    return path


def scored(*fitness: float) -> Evaluation:
    return Evaluation(
        {},
        fitness=sum(fitness) / len(fitness),
        episodes=tuple({"width.closeness": value} for value in fitness),
    )


def test_every_camera_is_judged_in_both_simulations(toys: Plugins, tmp_path: Path) -> None:
    question = Question(str(write(tmp_path)), {}, evaluations=4, design=4)
    effects = [{"use": "effect.vignetting", "k1": -0.3}]
    found = decide(question, effects, toys, InThisProcess(), Silent())
    names = {row["camera"] for row in found["cameras"]}
    assert names == {"flea3", "basler_dart", "designed"}
    assert all(row["without"] is not None and row["with"] is not None for row in found["cameras"])
    assert {"before", "after", "verdict"} <= set(found["choice"])
    assert set(found["ranking"]["with"]) == names
    assert set(found["designed"]) == {"without", "with"}


def test_nothing_changes_where_nothing_is_added(toys: Plugins, tmp_path: Path) -> None:
    found = decide(Question(str(write(tmp_path)), {}, 4, 0), [], toys, InThisProcess(), Silent())
    assert all(row["without"] == row["with"] for row in found["cameras"])
    assert not found["ranking_changes"]
    assert found["sentence"].startswith("The ranking of the cameras stays")
    assert found["designed"] == {}


def in_simulation(reference: str, **fitness: Sequence[float]) -> RankedCameras:
    """Cameras with a fitness on each scene, compared with one of them."""
    evaluations = {name: scored(*values) for name, values in fitness.items()}
    others = [name for name in fitness if name != reference]
    pairs = {name: np.subtract(fitness[reference], fitness[name]) for name in others}
    comparisons = {name: compared(pair, error=0.05, margin=0.01) for name, pair in pairs.items()}
    return ranked(evaluations, FITNESS, error=0.05, seed=1, comparisons=comparisons, reference=reference)


def said(before: RankedCameras, after: RankedCameras) -> tuple[str, str]:
    found = choice(before, after)
    return found.verdict, sentence(before, after, found, 0.95)


def test_the_choice_changes_only_where_the_scenes_tell() -> None:
    before = in_simulation("a", a=[3.0, 3.1, 2.9, 3.0], b=[1.0, 1.1, 0.9, 1.0])
    clear = said(before, in_simulation("a", a=[1.0, 1.1, 0.9, 1.02], b=[2.0, 2.1, 1.9, 2.0]))
    assert clear[0] == "changes"
    assert "b beats a by 0.995" in clear[1]
    unclear = said(before, in_simulation("a", a=[1.0, 1.4, 0.6, 1.0], b=[1.5, 0.7, 1.1, 0.9]))
    assert unclear[0] == "undecided"
    assert "do not decide" in unclear[1]
    same = said(before, in_simulation("a", a=[3.0, 3.1, 2.9, 3.0], b=[1.0, 1.1, 0.9, 1.02]))
    assert same[0] == "stays"
    assert "The camera to take stays: a;" in same[1]


def test_what_matters_less_than_the_margin_changes_nothing() -> None:
    before = in_simulation("a", a=[3.0, 3.1, 2.9, 3.0], b=[1.0, 1.1, 0.9, 1.0])
    after = in_simulation("a", a=[1.0, 1.1, 0.9, 1.0], b=[1.001, 1.102, 0.901, 1.002])
    verdict, text = said(before, after)
    assert verdict == "stays"
    assert "b is ahead by no more than matters" in text


def test_the_chance_to_be_best_counts_scenes_that_cameras_share() -> None:
    rng = np.random.default_rng(4)
    scenes = rng.normal(0, 5, 12)  # scenes differ far more than cameras do
    chances = chance_best({"a": scenes + 0.1, "b": scenes, "c": scenes + rng.normal(0.1, 1, 12)}, seed=2)
    assert sum(chances.values()) == pytest.approx(1)
    assert chances["b"] == 0.0
    assert 0 < chances["c"] < 1


def test_tasks_that_learn_keep_their_weights(toys: Plugins, tmp_path: Path) -> None:
    sections = merged(STUDY, LEARNER)
    path = tmp_path / "joint.yaml"
    path.write_text(yaml.safe_dump(sections))
    found = decide(Question(str(path), {}, 2, 0), [], toys, InThisProcess(), Silent())
    assert found["frozen"] == ["learner"]
    assert all(row["without"] == row["with"] is not None for row in found["cameras"])


def test_a_study_without_cameras_to_rank_is_refused(toys: Plugins, tmp_path: Path) -> None:
    path = write(tmp_path, compare=None)
    with pytest.raises(UserError, match="compares no cameras"):
        Question(str(path), {}, 4, design=0).plan(toys)
    Question(str(path), {}, 4, design=4).plan(toys)
