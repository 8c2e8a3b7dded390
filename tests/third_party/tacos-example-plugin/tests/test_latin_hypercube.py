"""The optimizer."""

from __future__ import annotations

import numpy as np
from tacos_framework.testing import OptimizerConformance

from tacos_example.latin_hypercube import LatinHypercube, latin_hypercube


class TestLatinHypercube(OptimizerConformance):
    component = LatinHypercube
    config = {"evaluations": 10, "batch": 3}


def test_each_stratum_of_each_gene_holds_one_point() -> None:
    points = latin_hypercube(50, 3, np.random.default_rng(1))
    strata = np.sort(np.floor(points * 50), axis=0)
    np.testing.assert_array_equal(strata, np.tile(np.arange(50)[:, None], 3))
