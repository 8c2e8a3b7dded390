"""Amplitude of an effect that lies a given number of noise floors off.

The measure is the generator's own and simpler than the solver's. From each capture few families of numbers
are taken: means and noise in tiles, gradients, correlation of neighbours, rows, codes, blocks, colours. Their
change by the effect is divided by the *noise floor*: how far the ideal camera differs from itself, together
with the equivalence margin (one per cent of the signal, eight per cent of a variance, and so on, see
`families`). The severity is the root mean square change of the capture and family that show it most.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from scipy import ndimage

from tacos_validation.blind.generators.acquisitions import Acquisition
from tacos_validation.blind.generators.camera import IdealCamera, IdealShot, Image
from tacos_validation.blind.generators.image_formation import expected, take
from tacos_validation.blind.generators.injected_effect import InjectedEffect

TILES = (5, 6)
MARGIN_SHIFT_PX = 0.3
N_REPLICATES = 4
ROUNDS = 6
CLOSE = 0.08
"""Relative distance from the wanted severity at which the search for an amplitude ends."""


def families(frames: Image, truth: Image, camera: IdealCamera) -> Iterator[tuple[str, Image, Image | float]]:
    """Name, numbers, and the equivalence margin of each.

    `frames`: (N, H, W, C) [DN]. `truth`: (N, H, W, C) noise-free [DN].
    """
    residual = frames - truth
    signal = _tiled(truth.mean(axis=0)).mean(axis=1) - camera.black_dn
    yield "level", _tiled(frames.mean(axis=0)).mean(axis=1), 0.01 * np.abs(signal) + 0.3
    if np.array_equal(truth[0], truth[-1]):
        noise = np.diff(residual, axis=0).mean(axis=0)
        yield "noise", np.log(_tiled(noise).var(axis=1) + 0.05), 0.08
    # edges a little off are negligible: 0.3 px times the slope there counts as noise
    scene = np.asarray(truth.mean(axis=0))
    steps = [np.diff(scene, axis=axis, append=np.nan) ** 2 for axis in (0, 1)]
    slack = MARGIN_SHIFT_PX**2 * np.nanmean(_tiled(steps[0] + steps[1]), axis=1)
    yield "residual", np.log(_tiled(residual.mean(axis=0)).var(axis=1) + slack + 0.05), 0.08
    for axis, name in ((0, "gradient_y"), (1, "gradient_x")):
        slope = np.diff(frames.mean(axis=0), axis=axis)
        yield name, np.log((_tiled(slope) ** 2).mean(axis=1) + 0.5), 0.05
    middle = residual - ndimage.uniform_filter(residual, (0, 15, 15, 0))  # leaves slow trends to the levels
    power = float((middle**2).mean()) + 1e-9
    pairs = [
        (middle[:, 1:] * middle[:, :-1]).mean() / power,
        (middle[:, :, 1:] * middle[:, :, :-1]).mean() / power,
    ]
    off = float(slack.mean())
    yield "neighbours", np.array(pairs), 0.02 + 0.5 * off / (off + power)
    margin = (0.003 * float(np.mean(truth))) ** 2 + off
    jitter = [np.diff(middle.mean(axis=axis), axis=1).var() for axis in (2, 1)]
    yield "rows", np.log(np.array(jitter) + margin + 1e-3), 0.15
    codes = [float((frames % step == 0).mean()) for step in (2, 3, 4)]
    yield "codes", np.array(codes), 0.05
    crest = np.quantile(frames, 0.999)
    ends = [float((frames >= crest - 1).mean()), float((frames == 0).mean())]
    yield "ends", np.array(ends), 0.02
    steepest = float(np.nanquantile(np.sqrt(steps[0]), 0.999)) * MARGIN_SHIFT_PX
    loose = 1.0 + 0.05 * float(np.ptp(truth)) + steepest + 0.01 * float(np.mean(truth))
    yield "extremes", np.quantile(residual, [0.0003, 0.9997]), loose
    jumps = np.abs(np.diff(frames, axis=2)).mean(axis=(0, 1, 3))
    yield "blocks", np.array([jumps[7::8].mean() / (np.delete(jumps, np.s_[7::8]).mean() + 0.1)]), 0.02
    lattice = [float((middle[:, i::2, j::2] ** 2).mean()) / power for i in (0, 1) for j in (0, 1)]
    yield "lattice", np.array(lattice), 0.03 + 0.5 * off / (off + power)
    if frames.shape[-1] == 3:
        flat = middle.reshape(-1, 3)
        related = np.asarray(np.corrcoef(flat[::7].T))
        yield "colours", related[np.triu_indices(3, 1)], 0.02 + 0.5 * off / (off + power)


def _tiled(image: Image) -> Image:
    """(tiles * C, pixels of a tile) of an (H, W, C) image."""
    rows, columns = TILES
    height, width = image.shape[0] // rows * rows, image.shape[1] // columns * columns
    cut = image[:height, :width].reshape(rows, height // rows, columns, width // columns, -1)
    return cut.transpose(0, 2, 4, 1, 3).reshape(rows * columns * image.shape[2], -1)


class NoiseFloor:
    """The ideal camera against itself, over the acquisitions of a case."""

    def __init__(self, acquisitions: Sequence[Acquisition], camera: IdealCamera, seed: int):
        self._acquisitions = [acquisition for acquisition in acquisitions if acquisition.board is None]
        self._camera = camera
        self._seed = seed
        self._truth = [
            np.stack([expected(shot) for shot in _two(acquisition)]) for acquisition in self._acquisitions
        ]
        draws = [self._numbers((), i) for i in range(N_REPLICATES)]
        self._clean = draws[0]
        self._sigma = {
            key: np.sqrt(_spread([draw[key][0] for draw in draws]) + margin**2)
            for key, (_, margin) in self._clean.items()
        }
        self._jitter = {
            key: float(np.mean([self._square(key, draw[key][0]) for draw in draws[1:]]))
            for key in self._clean
        }

    @property
    def measures(self) -> bool:
        return bool(self._clean)

    def severity(self, effects: Sequence[InjectedEffect]) -> float:
        """Distance of captures with the effects where it shows most; 0 for boards alone [noise floor]."""
        return max(self.changes(effects).values(), default=0.0)

    def changes(self, effects: Sequence[InjectedEffect]) -> dict[tuple[str, str], float]:
        """The same for each capture and family, less what other noise alone would change."""
        changed = self._numbers(effects, 0)
        return {
            key: float(np.sqrt(max(self._square(key, changed[key][0]) - self._jitter[key], 0.0)))
            for key in changed
        }

    def _square(self, key: tuple[str, str], numbers: Image) -> float:
        """Mean square distance from the clean numbers [noise floor^2]."""
        return float(np.mean(((numbers - self._clean[key][0]) / self._sigma[key]) ** 2))

    def _numbers(
        self, effects: Sequence[InjectedEffect], draw: int
    ) -> dict[tuple[str, str], tuple[Image, Image | float]]:
        numbers = {}
        for acquisition, truth in zip(self._acquisitions, self._truth, strict=True):
            rng = np.random.default_rng([self._seed, draw])
            frames = np.concatenate([take(shot, effects, 1, rng, self._seed) for shot in _two(acquisition)])
            for name, values, margin in families(frames, truth, self._camera):
                numbers[acquisition.id, name] = values, margin
        return numbers


def _spread(draws: Sequence[Image]) -> float:
    return float(np.mean(np.var(draws, axis=0, ddof=1)))


def _two(acquisition: Acquisition) -> Sequence[IdealShot]:
    """Two frames are enough to measure by."""
    shots = acquisition.shots
    return [shots[0], shots[-1]]


def calibrated(
    build: Callable[[float], InjectedEffect], wanted: float, floor: NoiseFloor, usual: float, largest: float
) -> tuple[InjectedEffect, float]:
    """The effect at the amplitude that has a wanted severity, and the severity it really has.

    Severity grows about as a power of the amplitude; steps along it until `CLOSE`, never beyond `largest`.
    Discrete effects come as close as they can.
    """
    amplitude = usual
    tried: dict[float, tuple[InjectedEffect, float]] = {}
    for _ in range(ROUNDS):
        effect = build(amplitude)
        tried[amplitude] = effect, floor.severity([effect])
        reached = tried[amplitude][1]
        if abs(reached / wanted - 1) < CLOSE:
            break
        following = min(amplitude * _factor(tried, wanted), largest)
        if following in tried:
            break
        amplitude = following
    return min(tried.values(), key=lambda pair: abs(np.log((pair[1] + 0.01) / wanted)))


def _factor(tried: dict[float, tuple[InjectedEffect, float]], wanted: float) -> float:
    """By what the amplitude changes next: along the power law between the two closest trials."""
    points = sorted(
        ((a, max(s, 0.02)) for a, (_, s) in tried.items()), key=lambda p: abs(np.log(p[1] / wanted))
    )
    (a, s) = points[0]
    power = 1.0
    if len(points) > 1 and points[1][1] != s:
        power = float(np.clip(np.log(points[1][1] / s) / np.log(points[1][0] / a), 0.5, 3.0))
    latest = list(tried)[-1]
    step = float(np.clip((wanted / s) ** (1 / power), 0.1, 10.0))
    return a * step / latest
