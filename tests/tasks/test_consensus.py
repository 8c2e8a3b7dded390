"""Matches without a common motion have no model, and that is no error."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tacos_plugins.tasks import consensus


def test_matches_of_one_motion_have_a_model() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform([-1, -1, 3], [1, 1, 6], (60, 3))
    moved = points + np.array([0.3, 0.05, 0.1])
    before, after = ((400 * p[:, :2] / p[:, 2:]).astype(np.float32) for p in (points, moved))
    settings = consensus.seeded(threshold_px=1.0, confidence=0.99, seed=1)
    found, agreeing = consensus.fundamental_matrix(before, after, settings)
    assert found is not None
    assert np.count_nonzero(agreeing) > 55


@pytest.mark.parametrize(("said", "passes"), [("(-215) !model.empty() in function", False), ("other", True)])
def test_only_the_missing_model_is_no_error(monkeypatch: pytest.MonkeyPatch, said: str, passes: bool) -> None:
    def refuses(*_: object) -> None:
        raise cv2.error(said)

    monkeypatch.setattr(cv2, "findFundamentalMat", refuses)
    points = np.zeros((8, 2), np.float32)
    if passes:
        with pytest.raises(cv2.error, match="other"):
            consensus.fundamental_matrix(points, points, None)
    else:
        assert consensus.fundamental_matrix(points, points, None) == (None, None)
