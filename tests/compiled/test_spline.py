"""The compiled spline gives the numbers of the framework, which takes it by its entry point."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import numpy as np
import pytest
from scipy.ndimage import spline_filter

from tacos_framework.camera import resampling
from tacos_plugins.compiled.spline import evaluate


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_it_gives_the_numbers_of_the_framework(dtype):
    rng = np.random.default_rng(3)
    coefficients = spline_filter(rng.uniform(0, 200, (40, 50)), resampling.ORDER, mode="nearest")
    column, row = rng.uniform(-20, 70, (2, 30, 60))
    compiled, plain = np.empty(column.shape, dtype), np.empty(column.shape, dtype)
    evaluate(coefficients, column, row, 20.0, 180.0, compiled)
    resampling.evaluate(coefficients, column, row, 20.0, 180.0, plain)
    np.testing.assert_allclose(compiled, plain, rtol=1e-6 if dtype == np.float32 else 1e-13)


@pytest.mark.parametrize("offered", [True, False])
def test_it_comes_in_by_its_entry_point(monkeypatch, offered):
    point = EntryPoint("spline", "tacos_plugins.compiled.spline:evaluate", resampling.LOOPS)
    asked = []

    def entry_points(**names):
        asked.append(names)
        return [point] if offered else []

    monkeypatch.setattr(resampling, "entry_points", entry_points)
    used = resampling._evaluator.__wrapped__()
    assert used is (evaluate if offered else resampling.evaluate)
    assert asked == [{"group": "tacos_loops", "name": "spline"}]
