"""The learning rate over a study."""

from __future__ import annotations

import pytest

pytest.importorskip("torchvision", reason="the extra perception is not installed")

from tacos_plugins.tasks.faster_rcnn.schedule import learning_rate
from tacos_plugins.tasks.faster_rcnn.task import FasterRcnn


def rate(passes, **changes):
    settings = FasterRcnn.Training(**changes)
    return learning_rate(
        passes,
        start=settings.learning_rate,
        decay=settings.decay,
        decay_every=settings.decay_every,
        floor=settings.decay_floor,
    )


def test_it_halves_every_five_passes_from_a_ten_thousandth():
    assert [rate(passes) for passes in (0, 4, 5, 9, 10, 15)] == pytest.approx(
        [1e-4, 1e-4, 5e-5, 5e-5, 2.5e-5, 1.25e-5]
    )


def test_it_does_not_collapse_over_the_200_candidates_of_a_study():
    """Stepped per candidate without a floor it would be 1e-16 at the end of the paper's study."""
    assert rate(200) == pytest.approx(5e-6)
    assert rate(200, decay_every=50) == pytest.approx(1e-4 / 16)
    assert rate(10**9) == rate(200)


def test_it_can_be_left_constant():
    assert rate(1000, decay=1.0) == 1e-4
