"""Writes captures as a folder that `read_captures` reads."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tacos_framework import to_yaml
from tacos_gap.captures.capture import Noise, RealCapture
from tacos_gap.captures.entry_files import written_entry
from tacos_gap.captures.lens_and_sensor import moved_filters
from tacos_gap.captures.missing import FILE


def write_captures(folder: str | Path, captures: Iterable[RealCapture]) -> Path:
    """Write images and ``captures.yaml``; returns its path.

    `captures`: taken one after another, all of one camera. Raises ValueError when the captures are not of one
    camera, ids would share a folder, or there are none.
    """
    writer = CaptureWriter(folder)
    for capture in captures:
        writer.add(capture)
    return writer.close()


@dataclass(frozen=True)
class WrittenCapture:
    """A capture whose files are on disk, in plain values that JSON keeps as they are."""

    entry: dict[str, Any]
    camera: dict[str, Any]
    shared: dict[str, Any]
    noise: dict[str, Any]


class CaptureWriter:
    """Writes captures one after another, and ``captures.yaml`` once all of them are there.

    Frames of whole numbers become PNG, of 8 bits where the white level allows it and of 16 where not; other
    frames, expectations, depth and motion become ``.npy``. An expectation that is the same everywhere is
    written as a number.
    """

    def __init__(self, folder: str | Path, written: Sequence[WrittenCapture] = ()) -> None:
        self._folder = Path(folder)
        self._written: list[WrittenCapture] = []
        self._noise: dict[float, Noise] = {}
        self._names: set[str] = set()
        for each in written:
            self._keep(each)

    @property
    def entries(self) -> list[dict[str, Any]]:
        return [each.entry for each in self._written]

    def add(self, capture: RealCapture) -> WrittenCapture:
        shared = _shared_by_all(capture)
        first = self._written[0] if self._written else None
        camera = first.camera if first else _camera_entry(capture, shared)
        before = first.shared if first else shared
        if differing := [key for key, value in shared.items() if not _alike(value, before[key])]:
            raise ValueError(
                f"captures {self.entries[0]['id']!r} and {capture.id!r} differ in {', '.join(differing)}: "
                f"those of a folder are of one camera"
            )
        name = _safe(capture.id)
        if name.lower() in self._names:
            raise ValueError(f"captures need ids that differ as names of folders: {capture.id!r} does not")
        noise = {"gain_db": float(capture.context.gain_db), **asdict(capture.noise)}
        self._check_noise(noise["gain_db"], capture.noise)
        (self._folder / name).mkdir(parents=True, exist_ok=True)
        written = WrittenCapture(written_entry(self._folder, name, capture, camera), camera, shared, noise)
        self._keep(written)
        return written

    def close(self) -> Path:
        if not self._written:
            raise ValueError("there are no captures to write")
        data = {
            "tacos_captures": 1,
            "camera": self._written[0].camera,
            "noise": _noise(self._noise),
            "captures": self.entries,
        }
        path = self._folder / FILE
        partial = path.with_name(f"{FILE}.partial")
        partial.write_text(to_yaml(data, flow_style=None), encoding="utf-8")
        partial.replace(path)
        return path

    def _check_noise(self, gain_db: float, noise: Noise) -> None:
        if self._noise.get(gain_db, noise) != noise and noise.known:
            raise ValueError(f"captures at {gain_db:g} dB have different noise")

    def _keep(self, written: WrittenCapture) -> None:
        gain_db, photon, thermal, known = (
            written.noise[key] for key in ("gain_db", "photon_dn", "thermal_dn2", "known")
        )
        self._noise.setdefault(gain_db, Noise(tuple(photon), tuple(thermal), known))
        self._names.add(_safe(written.entry["id"]).lower())
        self._written.append(written)


def _safe(name: str) -> str:
    return re.sub(r"[^\w.-]", "_", name).strip(".")[:60] or "_"


# camera and noise -----------------------------------------------------------------------------------------


def _camera_entry(capture: RealCapture, shared: Mapping[str, Any]) -> dict[str, Any]:
    geometry = capture.geometry
    x, y = geometry.offset_px
    stated = {key: value for key, value in shared.items() if key not in ("full", "centre", "cfa")}
    return {
        "width_px": geometry.width_px,
        "height_px": geometry.height_px,
        "crop": {"x": x, "y": y, **shared["full"]},
        **(
            {}
            if "principal_point" in capture.unstated
            else {"principal_point_px": [float(c) for c in geometry.centre_px]}
        ),
        **{key: value for key, value in stated.items() if value is not None},
        **({} if capture.context.cfa is None else {"cfa": capture.context.cfa}),
    }


def _shared_by_all(capture: RealCapture) -> dict[str, Any]:
    """Facts that all captures of a camera share; centre and filters those of the full sensor."""
    geometry, context = capture.geometry, capture.context
    white = float(context.white_level_dn)
    bits = max(1, math.ceil(math.log2(white + 1)))
    return {
        "full": {"full_width_px": geometry.full_width_px, "full_height_px": geometry.full_height_px},
        "centre": [c + o for c, o in zip(geometry.centre_px, geometry.offset_px, strict=True)],
        "pixel_um": float(geometry.pixel_um),
        "focal_length_mm": (
            None if "focal_length" in capture.unstated else geometry.focal_length_px * geometry.pixel_um / 1e3
        ),
        "projection": None if geometry.lens.is_rectilinear else geometry.lens.projection,
        "lens_coefficients": [*geometry.lens.coefficients] or None,
        "f_number": context.f_number,
        "bit_depth": bits,
        "white_level_dn": None if white == 2**bits - 1 else white,
        "black_level_dn": float(context.black_level_dn),
        "channels": capture.real_dn.shape[-1],
        "cfa": context.cfa and moved_filters(context.cfa, *(-offset for offset in geometry.offset_px)),
    }


def _alike(first: Any, second: Any) -> bool:
    if isinstance(first, list):
        return bool(np.allclose(first, second))
    return bool(math.isclose(first, second)) if isinstance(first, float) else bool(first == second)


def _noise(by_gain: Mapping[float, Noise]) -> Any:
    if not all(noise.known for noise in by_gain.values()):
        return "unknown"
    return [
        {"gain_db": gain_db, "photon_dn": _numbers(n.photon_dn), "thermal_dn2": _numbers(n.thermal_dn2)}
        for gain_db, n in by_gain.items()
    ]


def _numbers(values: Sequence[float]) -> Any:
    return float(values[0]) if len(set(values)) == 1 else [float(value) for value in values]
