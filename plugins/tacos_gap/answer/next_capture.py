"""The capture to take next: the kind on which the remaining explanations differ most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from tacos_framework import ImageGeometry
from tacos_gap.captures import RealCapture
from tacos_gap.evidence import ImageEvidence
from tacos_gap.evidence.boards import source_of
from tacos_gap.hypotheses.ambiguity import NextCapture
from tacos_gap.inference.problem import Hypothesis, placed, robust

_SIZE = (240, 320)
_TROUBLE = {
    "dark": 1.0,
    "flat": 1.3,
    "bracket": 1.6,
    "edge": 2.0,
    "chart": 2.5,
    "sequence": 3.0,
}
"""What a capture of each kind costs its photographer, relative to a dark."""

_WHY = {
    "dark": "with the cap on, at two exposure times, only electronics is left",
    "flat": "an even field at several levels, a stack each, shows noise, patterns and fall-off",
    "bracket": "levels against exposure times show the response",
    "edge": "sharp edges over the field show blur and its direction",
    "chart": "known colours show what mixes and bends channels",
    "sequence": "motion at a known velocity shows readout and exposure",
    "board": "tilted views of a board show geometry apart from pose",
}


_SHOWN_BY = {
    "bracket": ("level", "clipped", "top_level"),
    "dark": ("dark_level", "dark_field", "hot_pixels", "row_noise", "column_noise"),
    "flat": (
        "relative_illumination",
        "photon_transfer",
        "spatial_noise",
        "noise_over_field",
        "noise_autocorrelation",
        "channel_correlation",
        "fixed_pattern",
        "column_pattern",
        "row_pattern",
        "line_offset",
    ),
    "edge": ("detail", "colour_displacement"),
    "board": ("displacement",),
    "chart": ("patches", "colour_matrix"),
}
"""Statistics by the kind of capture that shows by itself what they are made of."""

_BLEMISHES = NextCapture(
    "flat",
    "the same even field at the smallest aperture: specks that grow darker and sharper lie on the sensor's "
    "cover glass; clean it, and take the flats anew",
)


def best_capture(
    captures: Sequence[RealCapture],
    hypotheses: Sequence[Hypothesis],
    seed: int,
    unexplained: str | None = None,
) -> NextCapture | None:
    """The kind with the largest expected difference between hypotheses for its trouble.

    Where there is nothing to choose between, the kind that shows what stays `unexplained`, the name of a
    statistic; else the kind that is missing and shows most.
    """
    if len(hypotheses) < 2:
        return _for_the_unexplained(captures, unexplained)
    worth: dict[str, float] = {}
    template = next((c for c in captures if c.expected_dn is not None), None)
    for a, b in combinations(hypotheses, 2):
        effects = [placed(hypothesis) for hypothesis in (a, b)]
        names = {term.name for term in a} ^ {term.name for term in b}
        differing = placed(tuple(term for term in (*a, *b) if term.name in names))
        if any(source_of(effect, captures[0].geometry) is not None for effect in differing):
            return NextCapture("board", _WHY["board"])  # the only one whose pose need not be known
        if template is None:
            continue
        for bench in _benches(template):
            evidence = ImageEvidence(bench, seed, replicates=4)
            one, two = (evidence.simulated(group) for group in effects)
            spread = evidence.sigma
            worth[bench.kind] = worth.get(bench.kind, 0.0) + float(np.sum(robust((one - two) / spread) ** 2))
    if not worth:
        return _for_the_unexplained(captures, unexplained)
    kind = max(worth, key=lambda k: worth[k] / _TROUBLE[k])
    return NextCapture(kind, _WHY[kind])


def _for_the_unexplained(captures: Sequence[RealCapture], statistic: str | None) -> NextCapture | None:
    """The kind that shows what a statistic is made of, else the first of those that are missing."""
    if statistic == "blemishes":
        return _BLEMISHES
    have = {capture.kind for capture in captures}
    wanted = [kind for kind, shown in _SHOWN_BY.items() if statistic in shown]
    missing = [k for k in (*wanted, "flat", "dark", "edge", "bracket", "board") if k not in have]
    return NextCapture(missing[0], _WHY[missing[0]]) if missing else None


def _benches(template: RealCapture) -> Iterator[RealCapture]:
    """Small captures of each kind, as the camera of `template` would be expected to see them."""
    height, width = _SIZE
    assert template.expected_dn is not None
    channels = template.expected_dn.shape[-1]
    context = template.context
    black = context.black_level_dn
    span = context.white_level_dn - black
    scale = width / template.geometry.full_width_px
    geometry = ImageGeometry(
        width,
        height,
        template.geometry.focal_length_px * scale,
        ((width - 1) / 2, (height - 1) / 2),
        template.geometry.pixel_um,
    )
    rows, columns = np.mgrid[:height, :width]
    squares = ((rows + columns // 8) // 40 + (columns - rows // 8) // 40) % 2
    ramp = np.clip(columns * 6 // width, 0, 5) / 5
    levels = {
        "dark": np.zeros(_SIZE),
        "flat": np.full(_SIZE, 0.5),
        "bracket": np.full(_SIZE, 0.9),
        "edge": 0.15 + 0.6 * squares,
        "chart": 0.05 + 0.75 * ramp,
    }
    for kind, level in levels.items():
        expected = np.repeat((black + span * level)[None, :, :, None], channels, axis=3).astype(np.float32)
        if kind == "chart" and channels == 3:
            expected[0, : height // 3, :, 0] *= 0.5
            expected[0, -height // 3 :, :, 2] *= 0.5
        yield replace(
            template,
            id=f"bench {kind}",
            kind=kind,
            real_dn=np.repeat(expected, 2, axis=0),  # margins go by what is seen
            expected_dn=expected,
            valid=np.ones(_SIZE, bool),
            geometry=geometry,
            context=replace(context, depth_m=None, exposure_s=1.0 if kind == "dark" else context.exposure_s),
            expected_frames=0,
            level_uncertainty=0.0,
            patches=None,
        )
