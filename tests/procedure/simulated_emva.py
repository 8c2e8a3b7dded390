"""A simulated camera of EMVA 1288 that writes folders of frames, apart from any code under test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np


@dataclass(frozen=True)
class Camera1288:
    """The linear model: Poisson electrons, noise of reading, gain, black level, rounding, clipping."""

    gain: float = 0.25
    efficiency: float = 0.5
    noise_e: float = 8.0
    black: float = 60.0
    bits: int = 12
    prnu: float = 0.01
    dsnu_e: float = 3.0
    dark_e_s: float = 400.0
    response: Callable[[np.ndarray], np.ndarray] = lambda dn: dn
    bands: float = 0.0
    drift: float = 0.0
    colours: np.ndarray | None = None
    size: tuple[int, int] = (96, 128)
    seed: int = 1

    def frames(
        self, photons: float, exposure_s: float, count: int, rng: np.random.Generator
    ) -> list[np.ndarray]:
        fixed = np.random.default_rng(self.seed)
        response = 1 + self.prnu * fixed.standard_normal(self.size)
        offset = self.dsnu_e * fixed.standard_normal(self.size)
        if self.colours is not None:
            response = response * np.tile(self.colours, (self.size[0] // 2, self.size[1] // 2))
        found = []
        for _ in range(count):
            rows = np.sin(np.arange(self.size[0]) / 7 + rng.uniform(0, 6))[:, None]
            light = photons * (1 + self.bands * rows) * (1 + self.drift * rng.standard_normal())
            electrons = rng.poisson(
                np.maximum(light * self.efficiency * response + self.dark_e_s * exposure_s, 0)
            )
            noisy = electrons + offset + self.noise_e * rng.standard_normal(self.size)
            dn = self.response(noisy * self.gain) + self.black
            found.append(
                np.clip(np.rint(dn), 0, 2**self.bits - 1).astype(np.uint16 if self.bits > 8 else np.uint8)
            )
        return found

    def write(
        self, folder: Path, *, levels: int = 16, stack: int = 0, per_level: int = 2, form: str = "npy",
        up: float = 1.1, photons_known: bool = True, seed: int = 5, dtype: str = "",
    ) -> Path:  # fmt: skip
        """A folder with frames.csv; exposures grow with the light."""
        folder.mkdir(parents=True, exist_ok=True)
        rng = np.random.default_rng(seed)
        full = (2**self.bits - 1 - self.black) / self.gain / self.efficiency
        lines = ["kind,exposure_ns,photons_per_pixel,file"]
        shares = np.linspace(0.03, up, levels)
        takes = [
            (f"{kind}{i}", kind, share, per_level)
            for kind in ("bright", "dark")
            for i, share in enumerate(shares)
        ]
        if stack:
            takes += [("bright_s", "bright", 0.5, stack), ("dark_s", "dark", 0.5, stack)]
        for name, kind, share, count in takes:
            photons = round(share * full) if kind == "bright" else 0
            for k, frame in enumerate(self.frames(photons, share * 0.01, count, rng)):
                file = f"{name}_{k}.{form}"
                if form == "npy":
                    np.save(folder / file, frame.astype(dtype or frame.dtype))
                else:
                    cv2.imwrite(str(folder / file), frame)
                told = photons if photons_known else ""
                lines.append(f"{kind},{share * 1e7:.0f},{told},{file}")
        (folder / "frames.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        return folder

    def but(self, **changes: object) -> Camera1288:
        """Another camera, changed in this."""
        return replace(self, **changes)  # type: ignore[arg-type]
