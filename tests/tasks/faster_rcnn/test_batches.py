"""Examples in batches: mixed, none lost, of like size."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("torchvision", reason="the extra perception is not installed")


from tacos_plugins.tasks.faster_rcnn.examples import Example, mixed_batches
from tacos_plugins.tasks.faster_rcnn.labels import frame_labels


def examples(count, width_px=lambda index: 8):
    """Examples that can be told apart by their first sample."""
    return [
        Example(
            np.full((6, width_px(i), 1), i, np.uint16), 0.0, 255.0, frame_labels(NO_IDS, NO_CLASSES, **ANY)
        )
        for i in range(count)
    ]


def number(example):
    return int(example.image_dn[0, 0, 0])


NO_IDS, NO_CLASSES = np.zeros((6, 8), np.int32), np.zeros(1, np.int64)


ANY = {"minimum_area_px": 1, "minimum_share": 0.0}


def test_frames_are_mixed_and_none_is_lost():
    batches = list(mixed_batches(iter(examples(100)), 4, 32, np.random.default_rng(0)))
    order = [number(example) for batch in batches for example in batch]
    assert sorted(order) == list(range(100))
    assert {len(batch) for batch in batches} == {4}
    assert sorted(order[:32]) == list(range(32))  # no more than that were held
    assert sum(abs(b - a) > 1 for a, b in pairwise(order)) > 80
    assert [len(batch) for batch in mixed_batches(examples(5), 4, 1, np.random.default_rng(0))] == [4, 1]


def test_a_batch_takes_images_of_like_size():
    """Padded to the largest, a small image would cost as much."""
    wide = examples(32, width_px=lambda index: 100 if index % 2 else 10)
    batches = list(mixed_batches(wide, 8, 32, np.random.default_rng(0)))
    assert [len({example.image_dn.shape for example in batch}) for batch in batches] == [1] * 4
