"""Samples as whole digital numbers: beside numpy, which rounds and clips one after the other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from tacos_framework.formation.arrays import digital, digitise

anything = st.floats(width=32) | st.integers(-5, 5).map(lambda whole: whole + 0.5)


@given(
    samples=arrays(np.float32, array_shapes(max_dims=4), elements=anything),
    white=st.sampled_from([255, 4095]),
)
def test_samples_are_rounded_and_clipped_as_numpy_does(samples, white):
    np.testing.assert_array_equal(digital(samples, white), np.clip(np.rint(samples), 0, white))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_views_and_other_floats_do_as_well_and_stay_as_they_are(dtype):
    samples = np.linspace(-3, 300, 240, dtype=dtype).reshape(2, 10, 12)
    before = samples.copy()
    found = digital(samples[:, ::2], 255)
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, np.clip(np.rint(samples[:, ::2].astype(np.float32)), 0, 255))
    np.testing.assert_array_equal(samples, before)


def test_files_have_the_type_their_white_level_asks_for():
    assert digitise(np.float32([0.4, 255.5]), 255).tolist() == [0, 255]
    assert digitise(np.float32([300.5]), 4095).dtype == np.uint16
