"""Average precision where it can be told by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_plugins.tasks.faster_rcnn.labels import Labels

pytest.importorskip("pycocotools", reason="the extra perception is not installed")

from tacos_plugins.tasks.faster_rcnn.average_precision import AveragePrecision, Detections

BOX = (10.0, 10.0, 30.0, 30.0)
ELSEWHERE = (50.0, 10.0, 70.0, 30.0)
CLASSES = ("sofa", "bed", "lamp")


def truth(*entries, counts=True):
    """Boxes of classes: (box, number)."""
    boxes = np.array([box for box, _ in entries], np.float32).reshape(-1, 4)
    numbers = np.array([number for _, number in entries], np.int64)
    return Labels(boxes, numbers, np.full(len(entries), counts))


def found(*entries):
    """Detections: (box, number, confidence)."""
    return Detections(
        np.array([box for box, _, _ in entries], np.float32).reshape(-1, 4),
        np.array([number for _, number, _ in entries], np.int64),
        np.array([confidence for _, _, confidence in entries], np.float32),
    )


def ap50(*frames):
    precision = AveragePrecision(CLASSES)
    for frame in frames:
        precision.add(*frame)
    return precision.scores("ap50")


def test_finding_everything_and_nothing_else_is_one():
    scores = ap50((truth((BOX, 1), (ELSEWHERE, 2)), found((BOX, 1, 0.9), (ELSEWHERE, 2, 0.3))))
    assert scores == pytest.approx({"ap50": 1.0, "ap50_sofa": 1.0, "ap50_bed": 1.0})


def test_the_first_object_of_the_first_frame_counts():
    """An annotation numbered 0 is never found, says COCO's code."""
    assert ap50((truth((BOX, 1)), found((BOX, 1, 0.9))))["ap50"] == pytest.approx(1.0)


def test_the_overlap_asked_for_is_a_half():
    half, less = (10.0, 10.0, 30.0, 20.1), (10.0, 10.0, 30.0, 19.9)
    assert ap50((truth((BOX, 1)), found((half, 1, 0.9))))["ap50"] == pytest.approx(1.0)
    assert ap50((truth((BOX, 1)), found((less, 1, 0.9))))["ap50"] == 0.0


def test_a_false_alarm_above_the_right_one_halves_precision_and_one_below_costs_nothing():
    right, wrong = (BOX, 1, 0.5), ELSEWHERE
    assert ap50((truth((BOX, 1)), found((wrong, 1, 0.9), right)))["ap50"] == pytest.approx(0.5)
    assert ap50((truth((BOX, 1)), found((wrong, 1, 0.1), right)))["ap50"] == pytest.approx(1.0)


def test_half_of_the_objects_found_is_half_the_recalls():
    two = truth((BOX, 1)), truth((ELSEWHERE, 1))
    scores = ap50((two[0], found((BOX, 1, 0.9))), (two[1], found()))
    assert scores["ap50"] == pytest.approx(51 / 101)  # of 101 recalls, 0 to 0.5 are reached


def test_the_right_place_with_the_wrong_class_is_nothing():
    assert ap50((truth((BOX, 1)), found((BOX, 2, 0.9)))) == {"ap50": 0.0, "ap50_sofa": 0.0}


def test_finding_an_object_twice_is_a_false_alarm():
    frames = [(truth((BOX, 1)), found((BOX, 1, 0.9), (BOX, 1, 0.8))), (truth((BOX, 1)), found((BOX, 1, 0.7)))]
    assert ap50(*frames)["ap50"] == pytest.approx((51 + 50 * 2 / 3) / 101)


def test_objects_that_do_not_count_are_neither_missed_nor_false():
    small = truth((ELSEWHERE, 1), counts=False)
    both = Labels(
        np.concatenate([truth((BOX, 1)).boxes_px, small.boxes_px]), np.array([1, 1]), np.array([True, False])
    )
    assert ap50((both, found((BOX, 1, 0.5))))["ap50"] == pytest.approx(1.0)
    assert ap50((both, found((ELSEWHERE, 1, 0.9), (BOX, 1, 0.5))))["ap50"] == pytest.approx(1.0)


def test_without_objects_there_is_no_score_and_without_detections_it_is_zero():
    assert ap50() == {}
    assert ap50((truth(), found((BOX, 1, 0.9)))) == {}
    assert ap50((truth((BOX, 1), counts=False), found())) == {}
    assert ap50((truth((BOX, 3)), found())) == {"ap50": 0.0, "ap50_lamp": 0.0}


def test_frames_are_kept_apart():
    """A detection in one frame does not find the object of another."""
    assert ap50((truth((BOX, 1)), found()), (truth(), found((BOX, 1, 0.9))))["ap50"] == 0.0


def test_it_keeps_quiet(capsys):
    ap50((truth((BOX, 1)), found((BOX, 1, 0.9))))
    assert capsys.readouterr().out == ""
