"""How channels mix: the matrix from expected to real colours, and patches of a chart."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tacos_framework.gap.statistics.block import Block, Sample

_LEAST_SPREAD = 0.01
"""Spread of colours, over full scale, below which a matrix cannot be told."""


def colour_statistics(sample: Sample) -> Iterator[Block]:
    """The least-squares matrix from expected to real linear colours; mean residuals of chart patches."""
    if len(sample.channels) != 3 or sample.capture.kind == "dark":
        return
    black = np.float32(sample.capture.context.black_level_dn)
    white = np.float32(sample.capture.context.white_level_dn - black)
    used = sample.valid & (sample.signal.max(axis=-1) < 0.9 * white)
    if used.sum() < 500:
        return
    expected = (sample.reference[used][::7] - black) / white
    real = (sample.mean[used][::7] - black) / white
    if (
        np.linalg.svd(expected - expected.mean(axis=0), compute_uv=False)[-1] / np.sqrt(len(expected))
        > _LEAST_SPREAD
    ):
        matrix = np.linalg.lstsq(expected, real, rcond=None)[0].T
        at = [{"from": "RGB"[column], "to": "RGB"[row]} for row in range(3) for column in range(3)]
        yield Block("colour_matrix", "isp", matrix.ravel(), at, 0.005)
    if sample.capture.patches is not None:
        boxes, _ = sample.capture.patches
        values = [sample.residual[y : y + h, x : x + w].mean(axis=(0, 1)) for x, y, w, h in boxes]
        places = [{"patch": int(k), "channel": c} for k in range(len(boxes)) for c in "RGB"]
        yield Block("patches", "isp", np.concatenate(values).astype(float), places, 0.3)
