"""What `optimizer.physical-gp` costs by itself: processor time of one proposal.

The problem is that of the tests: pitch, focal length and 43 sensors, three scores, four scenes::

    OMP_NUM_THREADS=1 python benchmarks/proposal_time.py
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tacos_plugins.optimizers.physical_gp.optimizer import PhysicalGp
from tests.optimizers.camera_problem import CameraProblem

OBSERVATIONS = (50, 100, 200)
ROUNDS = 10
"""Rounds that each figure is the mean of; fits of hyperparameters, one in some ten rounds, are among them."""


def milliseconds_of_proposals() -> dict[int, float]:
    """Processor time of a candidate asked once so many are observed [ms]."""
    camera = CameraProblem(1)
    config = PhysicalGp.Config(evaluations=1000)
    optimizer = PhysicalGp(config, space=camera.space, rng=np.random.default_rng(1), problem=camera.problem)
    spent: dict[int, list[float]] = {count: [] for count in OBSERVATIONS}
    observed = 0
    while any(len(each) < ROUNDS for each in spent.values()):
        start = time.process_time()
        asked = optimizer.ask()
        own = (time.process_time() - start) / len(asked)
        reached = max((count for count in OBSERVATIONS if count <= observed), default=None)
        if reached is not None and len(spent[reached]) < ROUNDS:
            spent[reached].append(own)
        optimizer.tell([camera.evaluate(each) for each in asked])
        observed += len(asked)
    return {count: 1e3 * float(np.mean(each)) for count, each in spent.items()}


if __name__ == "__main__":
    print("| observed | CPU time of a proposal |\n| --- | --- |")
    for count, milliseconds in milliseconds_of_proposals().items():
        print(f"| {count} | {milliseconds:.0f} ms |")
