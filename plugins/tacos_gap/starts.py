"""Where a search begins that the captures themselves can point to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_gap.captures import Capture
from tacos_gap.evidence import Evidence, ImageEvidence
from tacos_gap.parameters import Term, starts_of

Probe = Mapping[str, Any]

_DIRECTIONAL = 1.5
"""Gradients kept in one direction, over those in another, from which on blur seems to have a direction."""


def terms_for(name: str, cls: type[Any], evidence: Sequence[Evidence]) -> list[Term]:
    """The starts of an effect: those its class names, and those that these captures suggest."""
    captures = [e.capture for e in evidence if isinstance(e, ImageEvidence)]
    suggested = list(SUGGESTIONS[name](captures)) if name in SUGGESTIONS else []
    return [*starts_of(name, cls, suggested), *starts_of(name, cls)]


def _saturation(captures: Sequence[Capture]) -> Iterator[Probe]:
    """The value that many pixels share at the top of a capture, below full scale."""
    found = set()
    for capture in captures:
        top = float(capture.real_dn.max())
        if top < capture.context.white_level_dn and np.mean(capture.real_dn >= top - 2) > 0.01:
            found.add(top)
    for level in sorted(found)[-2:]:
        yield {"level_dn": level}


def _flicker(captures: Sequence[Capture]) -> Iterator[Probe]:
    """The strongest waves over the rows, refined between whole periods of the height."""
    power: dict[float, float] = {}
    lit = [c for c in captures if c.kind != "dark" and c.expected_dn is not None]
    for capture in lit:
        assert capture.expected_dn is not None
        signal = np.maximum(capture.expected_dn.mean(axis=0).mean(axis=-1), 1.0).sum(axis=1)
        rows = (capture.real_dn - capture.expected_dn).mean(axis=-1).sum(axis=2) / signal
        rows = rows - rows.mean(axis=0) if len(rows) > 2 else rows - rows.mean(axis=1, keepdims=True)
        height = rows.shape[1]
        spectrum = np.abs(np.fft.rfft(rows * np.hanning(height), n=8 * height, axis=1)).mean(axis=0)
        for k in range(6, min(8 * 60, len(spectrum))):
            period = round(8 * height / k, 2)
            power[period] = power.get(period, 0.0) + float(spectrum[k]) * 4 / height / len(lit)
    strongest = sorted(power, key=lambda period: -power[period])
    chosen: list[float] = []
    for period in strongest:
        if all(abs(np.log(period / other)) > 0.25 for other in chosen):
            chosen.append(period)
        if len(chosen) == 3:
            break
    for period in chosen:
        yield {"depth": max(power[period], 0.005), "period_rows": period}


def _matrix(captures: Sequence[Capture]) -> Iterator[Probe]:
    """The least-squares matrix of the capture with the widest range of colours, rows scaled to sum to 1."""
    best: tuple[float, Any] = (0.0, None)
    for capture in captures:
        if capture.expected_dn is None or capture.expected_dn.shape[-1] != 3 or capture.kind == "dark":
            continue
        black, white = capture.context.black_level_dn, capture.context.white_level_dn
        expected = capture.expected_dn.mean(axis=0)
        used = capture.valid & (expected.max(axis=-1) < 0.9 * white)
        a = (expected[used] - black)[::11]
        b = (capture.real_dn.mean(axis=0)[used] - black)[::11]
        if len(a) < 100:
            continue
        spread = float(np.linalg.svd(a - a.mean(axis=0), compute_uv=False)[-1]) / np.sqrt(len(a)) / white
        if spread > max(best[0], 0.005):
            matrix = np.linalg.lstsq(a, b, rcond=None)[0].T
            best = (spread, matrix / matrix.sum(axis=1, keepdims=True))
    if best[1] is not None:
        yield {"matrix": best[1].tolist()}


def _motion(captures: Sequence[Capture]) -> Iterator[Probe]:
    """The direction whose gradients have lost most against the expectation, at lengths beyond the usual."""
    steepest: tuple[float, float] = (_DIRECTIONAL, 0.0)
    for capture in captures:
        if not capture.is_structured or capture.expected_dn is None:
            continue
        real, expected = (
            _gradient_energy(f.mean(axis=0), capture) for f in (capture.real_dn, capture.expected_dn)
        )
        angles = np.arange(0.0, 180.0, 5.0)
        along = np.stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))])
        kept = np.einsum("ia,ij,ja->a", along, real, along) / np.einsum("ia,ij,ja->a", along, expected, along)
        anisotropy = float(kept.max() / max(kept.min(), 1e-9))
        if anisotropy > steepest[0]:
            steepest = anisotropy, float(angles[np.argmin(kept)])
    if steepest[0] > _DIRECTIONAL:
        for length in (10.0, 22.0):
            yield {"length_px": length, "angle_deg": steepest[1]}


def _gradient_energy(image: NDArray[np.float32], capture: Capture) -> NDArray[np.float64]:
    """(2, 2) mean outer product of the gradient, x before y [DN^2 per px^2]."""
    down, right = np.gradient(image.mean(axis=-1))
    gradients = np.stack([right[capture.valid], down[capture.valid]])
    return np.asarray(gradients @ gradients.T / gradients.shape[1] + 1e-6 * np.eye(2), np.float64)


SUGGESTIONS: Mapping[str, Callable[[Sequence[Capture]], Iterator[Probe]]] = {
    "saturation": _saturation,
    "flicker": _flicker,
    "colour-matrix": _matrix,
    "motion-blur": _motion,
}
"""Effects whose search needs a hint, since far from the truth nothing points to it."""
