"""The learning rate, from how much was trained before."""

from __future__ import annotations


def learning_rate(steps: int, *, start: float, decay: float, decay_every: int, floor: float) -> float:
    """The learning rate after so many steps: `start` times `decay` for every `decay_every` steps.

    A step is a pass over the training frames, not a batch, and the count is part of the task's state: in a
    study with shared weights it rises by one with each candidate, with branched ones by one a generation.

    - `start`: learning rate of the first pass.
    - `decay`: factor of each decay.
    - `floor`: share of `start` it never falls below: the weights of a long study still move at its end.

    Source: the paper, Sec. 4.3, "Object Detector": 1e-4, halved every five steps.

    >>> [round(learning_rate(n, start=1e-4, decay=0.5, decay_every=5, floor=0.01), 9) for n in (4, 5, 999)]
    [0.0001, 5e-05, 1e-06]
    """
    return start * max(floor, decay ** (steps // decay_every))
