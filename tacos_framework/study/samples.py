"""Sample frames of the cameras of a study, to look at."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_framework.camera.clipping import Exposed, mean_exposed
from tacos_framework.contracts import Executor
from tacos_framework.simulation import EpisodeSpec, Evaluator, SampleJob
from tacos_framework.store import Results

SAMPLES_AT = (0.15, 0.5, 0.85)
"""Places of sample frames along the episode [share of the episode]."""


def write_samples(
    cameras: Mapping[str, Mapping[str, Any]],
    episode: EpisodeSpec,
    executor: Executor,
    evaluate: Evaluator,
    results: Results,
) -> tuple[dict[str, list[str]], dict[str, Exposed]]:
    """Write frames of the first camera of each rig; none of a rig that fails.

    `cameras`: plain values of the design variables, by the name of the designed camera or product.

    Returns: paths within the folder, and how the frames are exposed, by name.
    """
    jobs = [SampleJob(values, episode, SAMPLES_AT) for values in cameras.values()]
    written: dict[str, list[str]] = {}
    exposed: dict[str, Exposed] = {}
    for name, frames in zip(cameras, executor.map(evaluate, jobs), strict=True):
        written[name] = [results.write_sample(f"{name}_{i}", each.picture) for i, each in enumerate(frames)]
        if frames:
            exposed[name] = mean_exposed([each.exposed for each in frames])
    return written, exposed
