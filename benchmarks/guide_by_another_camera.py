"""The pictures of `tacos captures guide` by a camera model of other packages, from import to patched.yaml.

python benchmarks/guide_by_another_camera.py --out another_camera

prysm forms the blur of a lens out of focus and reads a detector out, OpenCV bends the lens; nothing of the
simulator that is diagnosed takes part. Printed are the seconds of each step, and truth beside what was found.
Needs: pip install prysm 'setuptools<81'
"""

from __future__ import annotations

import argparse
import json
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from prysm import coordinates, geometry, propagation
from prysm.detector import Detector

WIDTH, HEIGHT, FINER = 640, 480, 4
PIXEL_UM, F_NUMBER, WAVELENGTH_UM, DEFOCUS_WAVES = 3.45, 4.0, 0.55, 0.45
MATRIX = np.array([[700.0, 0, 326], [0, 700, 236], [0, 0, 1]])
DISTORTION = np.array([-0.15, 0.04, 0, 0, 0])
FALL_OFF = (-0.30, 0.05)  # of r^2 and r^4, r over half the diagonal
PRNU, ELECTRONS_PER_S = 0.01, 540_000.0
DARK_E_S, READ_NOISE_E, PEDESTAL_E, FULL_WELL_E, E_PER_DN = 60.0, 6.0, 300.0, 12_500.0, 3.0
WORKING_MS = 20.0
Light = NDArray[np.float64]
"""(FINER HEIGHT, FINER WIDTH) radiance, 1 is white."""


def main() -> None:
    """Take the pictures, ask, and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="a new folder")
    out = parser.parse_args().out
    (out / "photos").mkdir(parents=True)
    count = sum(_saved(out / "photos", name, frames) for name, frames in pictures(Camera()))
    print(f"{count} pictures of {WIDTH} x {HEIGHT}")
    for command in (
        f"tacos captures import {out}/photos --out {out}/captures",
        f"tacos captures check {out}/captures",
        f"tacos-run diagnose --set captures={out}/captures --out {out}/diagnosis",
        f"tacos-run headset_quick --with {out}/diagnosis/patched.yaml --check",
    ):
        begun = time.perf_counter()
        subprocess.run(command.split(), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        print(f"{time.perf_counter() - begun:6.1f} s  {command}")
    answer = json.loads((out / "diagnosis" / "diagnosis.json").read_text())
    print(f"{answer['verdict']}: gap {answer['gap']}")
    for cause in answer["causes"]:
        values = {name: (found["value"], found.get("ci")) for name, found in cause["parameters"].items()}
        print(f"{cause['effect']:>18} {cause['present']:.2f}  {values}")
    dark_dn_s = DARK_E_S * np.exp(-0.3 + 0.7**2 / 2) / E_PER_DN
    print(
        f"truth: vignetting {FALL_OFF}, lens-distortion {DISTORTION[:2]}, prnu {PRNU}, dark current of "
        f"{dark_dn_s:.1f} DN/s on average, out of focus by {_spread_px(point_spread()):.2f} px rms"
    )


class Camera:
    """One specimen: its lens, and the patterns of its pixels."""

    def __init__(self) -> None:
        np.random.seed(4)  # noqa: NPY002 (what the detector of prysm draws from)
        rng = np.random.default_rng(4)
        self._psf = point_spread()
        x, y = pixel_places()
        r2 = ((x - MATRIX[0, 2]) ** 2 + (y - MATRIX[1, 2]) ** 2) / (WIDTH**2 + HEIGHT**2) * 4
        self._fall_off = 1 + FALL_OFF[0] * r2 + FALL_OFF[1] * r2**2
        self._prnu = rng.normal(1, PRNU, HEIGHT * WIDTH)
        self._dark = rng.lognormal(-0.3, 0.7, (HEIGHT, WIDTH))

    def frames(self, light: Light, exposure_ms: float, count: int) -> NDArray[np.uint16]:
        """(count, H, W) files [DN]."""
        blurred = cv2.filter2D(light * self._fall_off, -1, self._psf, borderType=cv2.BORDER_REFLECT)
        pixels = blurred.reshape(HEIGHT, FINER, WIDTH, FINER).mean(axis=(1, 3))
        detector = Detector(
            DARK_E_S,
            READ_NOISE_E,
            PEDESTAL_E,
            FULL_WELL_E,
            E_PER_DN,
            bits=12,
            exposure_time=exposure_ms / 1e3,
            prnu=self._prnu,
            dcnu=self._dark,
        )
        files = detector.expose(pixels * ELECTRONS_PER_S, frames=count).reshape(count, HEIGHT, WIDTH)
        return np.minimum(files, 4095).astype(np.uint16)


def pictures(camera: Camera) -> Iterator[tuple[str, NDArray[np.uint16]]]:
    """Names and frames of what the guide asks for; no ColorChecker, as the camera is monochrome."""
    x, y = pixel_places()
    nothing, slope = np.zeros_like(x), 1 + 0.04 * (x / WIDTH - 0.5)
    for exposure_ms in (WORKING_MS, 10 * WORKING_MS):
        yield f"cap_{exposure_ms:g}ms", camera.frames(nothing, exposure_ms, 4)
    for level in (0.2, 0.5, 0.8):
        yield f"wall_{level * 100:.0f}_{WORKING_MS:g}ms", camera.frames(level * slope, WORKING_MS, 4)
    turned = 0.5 * (1 + 0.04 * (y / HEIGHT - 0.5))
    yield f"wall_turned_{WORKING_MS:g}ms", camera.frames(turned, WORKING_MS, 4)
    view = lamp_to_shadow()
    for exposure_ms in (2.5, 5.0, 10.0, 20.0, 40.0):
        yield f"view_{exposure_ms:g}ms", camera.frames(view, exposure_ms, 2)
    for turn_deg in (5, 95):
        for place, (left, top) in {"middle": (320, 240), "corner": (540, 90)}.items():
            paper = straight_edge(turn_deg, left, top)
            yield f"edge_{place}_{turn_deg}_{WORKING_MS:g}ms", camera.frames(paper, WORKING_MS, 2)
    for k, (turns, place_m) in enumerate(BOARDS):
        yield f"board_{k}_{WORKING_MS:g}ms", camera.frames(chessboard(turns, place_m), WORKING_MS, 1)


BOARDS = (
    ((0.4, 0.1, 0.0), (0.0, 0.0, 0.45)),
    ((-0.4, 0.2, 0.1), (0.05, -0.02, 0.45)),
    ((0.1, 0.5, 0.0), (-0.06, 0.03, 0.48)),
    ((0.1, -0.5, -0.1), (0.06, -0.03, 0.5)),
    ((0.3, 0.3, 0.3), (-0.05, -0.05, 0.5)),
    ((-0.3, -0.35, 0.0), (0.04, 0.05, 0.47)),
    ((0.05, 0.05, 1.5), (0.0, 0.0, 0.5)),
)
"""Turn as a Rodrigues vector [rad] and place [m] of a board of 10 x 7 squares of 30 mm."""


def pixel_places() -> tuple[Light, Light]:
    """Columns and rows of the finer picture in pixels of the file."""
    x, y = np.meshgrid(np.arange(WIDTH * FINER), np.arange(HEIGHT * FINER))
    return (x + 0.5) / FINER - 0.5, (y + 0.5) / FINER - 0.5


def point_spread() -> Light:
    """(65, 65) of a lens out of focus, in parts of a pixel."""
    x, y = coordinates.make_xy_grid(256, diameter=10)
    r, _ = coordinates.cart_to_polar(x, y)
    path_nm = DEFOCUS_WAVES * (r / 5) ** 2 * WAVELENGTH_UM * 1e3
    pupil = geometry.circle(5, r)
    field = propagation.Wavefront.from_amp_and_phase(pupil, path_nm, WAVELENGTH_UM, x[0, 1] - x[0, 0])
    spread = field.focus_fixed_sampling(F_NUMBER * 10, PIXEL_UM / FINER, 65).intensity.data
    return np.asarray(spread / spread.sum(), np.float64)


def _spread_px(spread: Light) -> float:
    across = np.arange(len(spread)) - len(spread) // 2
    return float(np.sqrt((spread * across**2).sum()) / FINER)


def lamp_to_shadow() -> Light:
    """Clouds of several sizes with forty boards before them, brightest where the lamp is."""
    rng = np.random.default_rng(1)
    clouds = np.zeros((HEIGHT * FINER // 8, WIDTH * FINER // 8))
    for size in (2, 5, 12, 30):
        clouds += cv2.GaussianBlur(rng.normal(size=clouds.shape), (0, 0), size) * size
    clouds = (clouds - clouds.min()) / np.ptp(clouds)
    view = cv2.resize(clouds, (WIDTH * FINER, HEIGHT * FINER), interpolation=cv2.INTER_CUBIC)
    for _ in range(40):
        corner = rng.integers(0, WIDTH * FINER, 2)
        far = corner + rng.integers(60, 400, 2)
        cv2.rectangle(view, corner.tolist(), far.tolist(), float(rng.uniform(0.01, 1)), -1)
    return np.clip(view, 0.01, 1)


def straight_edge(turn_deg: float, left_px: float, top_px: float) -> Light:
    """Black paper on white, its edge through a place."""
    x, y = pixel_places()
    turn = np.deg2rad(turn_deg)
    return np.where((x - left_px) * np.cos(turn) + (y - top_px) * np.sin(turn) > 0, 0.7, 0.06)


def chessboard(turns: tuple[float, ...], place_m: tuple[float, ...]) -> Light:
    """A board with a white border of one square, as the lens of OpenCV's model sees it."""
    x, y = pixel_places()
    seen = np.stack([x.ravel(), y.ravel()], axis=1)[:, None]
    until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-9)
    straight = cv2.undistortPoints(seen, MATRIX, DISTORTION, None, None, None, until).reshape(*x.shape, 2)
    rays = np.concatenate([straight, np.ones((*x.shape, 1))], axis=2)
    rotation, _ = cv2.Rodrigues(np.array(turns))
    place = np.array(place_m)
    normal = rotation[:, 2]
    at = (rays * ((normal @ place) / (rays @ normal))[..., None] - place) @ rotation / 0.03
    column, row = at[..., 0] + 5, at[..., 1] + 3.5
    is_board = (column > 0) & (column < 10) & (row > 0) & (row < 7)
    is_paper = (column > -1) & (column < 11) & (row > -1) & (row < 8)
    is_black = is_board & ((np.floor(column) + np.floor(row)) % 2 == 0)
    return np.where(is_black, 0.05, np.where(is_paper, 0.7, 0.25))


def _saved(folder: Path, name: str, frames: NDArray[np.uint16]) -> int:
    for k, frame in enumerate(frames):
        cv2.imwrite(str(folder / f"{name}_{k}.png"), frame)
    return len(frames)


if __name__ == "__main__":
    main()
