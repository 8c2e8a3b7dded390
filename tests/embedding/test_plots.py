"""Figures of results: what is drawn is what the result holds."""

from __future__ import annotations

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

import tacos
from tacos_decision import StudyResult
from tacos_gap.report.result_tables import DiagnosisResult

matplotlib.use("Agg")

RANKED = [
    {
        "part": "A",
        "camera": {},
        "fitness": 2.0,
        "ci": [1.5, 2.5],
        "p_better": {},
        "episodes": 8,
        "unknown": [],
    },
    {
        "part": "B",
        "camera": {},
        "fitness": 1.0,
        "ci": [0.0, 2.0],
        "p_better": {},
        "episodes": 0,
        "unknown": [],
    },
]


def candidate(fitness: float | None, images: int) -> dict[str, object]:
    fixed = {"key": "k", "failed": None, "camera": {}, "derived": {}, "scores": {}, "episodes": {}}
    return {**fixed, "fitness": fitness, "images": images}


def axes():
    return Figure().add_subplot()


def test_the_ranking_is_drawn_from_the_top_and_what_was_only_predicted_is_hollow() -> None:
    drawn = tacos.plot.ranking(StudyResult({"ranking": RANKED}), axes=axes())
    dots = [line for line in drawn.lines if line.get_marker() == "o"]
    assert [float(line.get_xdata()[0]) for line in dots] == [2.0, 1.0]
    assert [line.get_fillstyle() for line in dots] == ["full", "none"]
    assert [label.get_text() for label in drawn.get_yticklabels()] == ["A", "B"]
    assert drawn.yaxis_inverted()


def test_progress_counts_images_of_failures_and_leaves_products_out() -> None:
    lines = [
        {"generation": 0, "candidates": [candidate(1.0, 6), candidate(None, 6), candidate(0.5, 6)]},
        {"generation": 0, "product": "flea3", "candidates": [candidate(9.0, 6)]},
        {"generation": 1, "candidates": [candidate(1.5, 0)]},
    ]
    tried, best = tacos.plot.progress(StudyResult({}, lines), axes=axes()).lines
    assert np.column_stack([tried.get_xdata(), tried.get_ydata()]).tolist() == [
        [6, 1.0],
        [18, 0.5],
        [18, 1.5],
    ]
    assert list(best.get_ydata()) == [1.0, 1.0, 1.5]


def test_scores_by_scene_keep_the_place_of_a_scene_without_the_score() -> None:
    cameras = {
        "designed": {"title": "Designed", "episodes": [{"seen": 1.0}, {}, {"seen": 0.5}]},
        "flea3": {"title": "FLIR Flea3", "episodes": [{"seen": 0.2}]},
    }
    drawn = tacos.plot.scores_by_scene(StudyResult({"cameras": cameras}), "seen", axes=axes())
    assert [list(line.get_xdata()) for line in drawn.lines] == [[0, 2], [0]]
    assert [text.get_text() for text in drawn.get_legend().get_texts()] == ["Designed", "FLIR Flea3"]


def test_a_score_that_is_not_there_is_named_with_those_that_are() -> None:
    cameras = {"designed": {"title": "Designed", "episodes": [{"seen": 1.0}]}}
    with pytest.raises(tacos.UserError, match="'sen' of test scenes") as refused:
        tacos.plot.scores_by_scene(StudyResult({"cameras": cameras}), "sen", axes=axes())
    assert "seen" in refused.value.faults[0].expected


def test_a_study_without_a_ranking_says_why() -> None:
    absent = {"ranking": [], "ranking_absent": "a single scene"}
    with pytest.raises(tacos.UserError, match="no ranking") as refused:
        tacos.plot.ranking(StudyResult(absent), axes=axes())
    assert refused.value.faults[0].expected == "a single scene"


def test_the_waterfall_of_a_diagnosis_ends_at_what_is_unexplained() -> None:
    causes = [{"effect": "prnu", "shapley": 0.6}, {"effect": "jpeg", "shapley": 0.3}]
    bars = tacos.plot.closure(DiagnosisResult({"causes": causes}), axes=axes()).patches
    ends = [(bar.get_y() + bar.get_height()) for bar in bars]
    assert ends == pytest.approx([1.0, 0.4, 0.1, 0.1])
    assert bars[1].get_y() == 1.0


def test_without_axes_a_new_figure_is_made() -> None:
    drawn = tacos.plot.ranking(StudyResult({"ranking": RANKED}))
    assert drawn is not tacos.plot.ranking(StudyResult({"ranking": RANKED}))
    matplotlib.pyplot.close("all")
