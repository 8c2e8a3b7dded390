"""Boxes from id images that were made by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from toy_detection import squares

from tacos_plugins.tasks.faster_rcnn.labels import class_numbers, frame_labels


def labels(ids, of=(0, 1, 2, 0), minimum_area_px=1, minimum_share=0.0):
    return frame_labels(
        np.array(ids, np.int32), np.array(of), minimum_area_px=minimum_area_px, minimum_share=minimum_share
    )


def test_a_box_spans_the_visible_pixels_from_edge_to_edge():
    found = labels([[0, 0, 0, 0], [0, 1, 1, 0], [0, 0, 1, 2]])
    assert found.boxes_px.tolist() == [[1, 1, 3, 3], [3, 2, 4, 3]]
    assert found.classes.tolist() == [1, 2]


def test_an_object_behind_another_has_one_box_around_all_that_is_seen_of_it():
    found = labels([[1, 2, 1], [1, 2, 1]])
    assert found.boxes_px.tolist() == [[0, 0, 3, 2], [1, 0, 2, 2]]


def test_classes_that_are_not_looked_for_have_no_box():
    assert len(labels([[3, 3], [0, 0]])) == 0
    assert labels([[3, 3], [0, 0]]).boxes_px.shape == (0, 4)


def test_two_objects_of_a_class_are_two():
    assert labels([[1, 2]], of=(0, 5, 5)).classes.tolist() == [5, 5]


@pytest.mark.parametrize(
    ("area_px", "share", "counts"),
    [(4, 0.0, [True, False]), (1, 0.5, [True, False]), (5, 0.0, [False, False]), (1, 0.1, [True, True])],
)
def test_what_is_too_small_is_there_but_does_not_count(area_px, share, counts):
    found = labels([[1, 1, 2, 0], [1, 1, 0, 0]], minimum_area_px=area_px, minimum_share=share)
    assert found.counts.tolist() == counts
    assert len(found.counted()) == sum(counts)


@given(arrays(np.int32, (7, 9), elements=st.integers(0, 3)))
def test_mirroring_ids_mirrors_boxes(ids):
    straight, turned = labels(ids).mirrored(9), labels(ids[:, ::-1])
    assert straight.boxes_px.tolist() == turned.boxes_px.tolist()
    assert straight.classes.tolist() == turned.classes.tolist()


@given(arrays(np.int32, (6, 5), elements=st.integers(0, 3)))
def test_every_pixel_of_an_object_lies_in_its_box_and_touches_each_side(ids):
    found = labels(ids)
    for number, (left, top, right, bottom) in zip(found.classes, found.boxes_px.astype(int), strict=True):
        rows, columns = np.nonzero(ids == number)  # ids and class numbers are the same here
        assert (rows.min(), rows.max() + 1, columns.min(), columns.max() + 1) == (top, bottom, left, right)


def test_classes_are_numbered_from_one_by_name():
    world = squares(classes=("bed", "threshold", "sofa")).episode.world
    assert class_numbers(world, ("sofa", "bed")).tolist() == [0, 2, 0, 1]
