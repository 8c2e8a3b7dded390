"""Whether a study would decide otherwise with effects added."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from toy_study import FROM_CATALOG

from tacos_framework import UserError
from tacos_framework.plugins import Plugins
from tacos_framework.simulation import Evaluation
from tacos_framework.study.progress import Silent
from tacos_framework.testing.procedure import InThisProcess
from tacos_gap.procedures.decision import Question, decide, sentence

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


def write(folder: Path, **changes: Any) -> Path:
    path = folder / "toy.yaml"
    path.write_text(yaml.safe_dump({key: v for key, v in {**STUDY, **changes}.items() if v is not None}))
    return path


def scored(*fitness: float) -> Evaluation:
    return Evaluation(
        {}, fitness=sum(fitness) / len(fitness), episodes=tuple({"fitness": value} for value in fitness)
    )


def test_every_camera_is_judged_in_both_simulations(toys: Plugins, tmp_path: Path) -> None:
    question = Question(str(write(tmp_path)), {}, evaluations=4, design=4)
    effects = [{"use": "effect.vignetting", "k1": -0.3}]
    found = decide(question, effects, toys, InThisProcess(), Silent())
    names = {row["camera"] for row in found["cameras"]}
    assert names == {"flea3", "basler_dart", "designed"}
    assert all(row["without"] is not None and row["with"] is not None for row in found["cameras"])
    assert set(found["ranking"]["with"]) == names
    assert set(found["designed"]) == {"without", "with"}


def test_nothing_changes_where_nothing_is_added(toys: Plugins, tmp_path: Path) -> None:
    found = decide(Question(str(write(tmp_path)), {}, 4, 0), [], toys, InThisProcess(), Silent())
    assert all(row["without"] == row["with"] for row in found["cameras"])
    assert not found["ranking_changes"]
    assert found["sentence"].startswith("The ranking of the cameras stays")
    assert found["designed"] == {}


def test_a_change_of_the_best_is_called_chance_within_its_interval() -> None:
    rankings = {"without": ["a", "b"], "with": ["b", "a"]}
    clear = sentence(rankings, {"a": scored(1.0, 1.1, 0.9), "b": scored(2.0, 2.1, 1.9)})
    unclear = sentence(rankings, {"a": scored(1.0, 1.4, 0.6), "b": scored(1.5, 0.7, 1.1)})
    assert "The best one changes, by 1.000" in clear
    assert "may be chance" in unclear


def test_a_study_without_cameras_to_rank_is_refused(toys: Plugins, tmp_path: Path) -> None:
    path = write(tmp_path, compare=None)
    with pytest.raises(UserError, match="compares no cameras"):
        Question(str(path), {}, 4, design=0).plan(toys)
    Question(str(path), {}, 4, design=4).plan(toys)
