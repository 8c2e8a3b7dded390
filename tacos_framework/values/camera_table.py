"""Cameras as a table with units, for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tacos_framework.values.camera import Camera


def cameras_as_html(cameras: Sequence[Camera]) -> str:
    """A table with a column for each camera, and a row for each quantity that is known of one of them."""
    columns = [dict(_quantities(camera)) for camera in cameras]
    names = list(dict.fromkeys(name for column in columns for name in column))
    rows = [["", *(camera.name for camera in cameras)]]
    rows += [[name, *(column.get(name, "") for column in columns)] for name in names]
    cells = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    return f"<table>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


def _quantities(camera: Camera) -> Iterator[tuple[str, str]]:
    """Names with units, and values."""
    yield "image [px]", f"{camera.width_px} x {camera.height_px}"
    yield "photosite pitch [um]", f"{camera.pixel_um:.4g}"
    if camera.binning != 1:
        yield "binning [1]", f"{camera.binning:g}"
    yield "focal length [mm]", f"{camera.focal_length_mm:.4g}"
    yield "focal length [px]", f"{camera.focal_length_px:.5g}"
    if not camera.lens.is_pinhole:
        yield "projection", camera.lens.projection
    yield "field of view [deg]", f"{camera.hfov_deg:.1f} x {camera.vfov_deg:.1f}"
    yield "position on the agent, x y z [m]", _vector(camera.agent_from_camera[:3, 3])
    yield "looks along, x y z [1]", _vector(camera.agent_from_camera[:3, 2])
    known = camera.electrons
    if known.sensor:
        yield "image sensor", known.sensor
    for name, value in (
        ("quantum efficiency [1]", known.quantum_efficiency),
        ("full well [e-]", known.full_well_e),
        ("read noise [e-]", known.read_noise_e),
        ("dark current [e-/s]", known.dark_current_e_s),
    ):
        if value is not None:
            yield name, f"{value:.4g}"


def _vector(values: Iterable[float]) -> str:
    return " ".join(f"{value:.3g}" for value in values)
