"""The hero: what the designed camera sees, with the frames of the others drawn into it."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from tacos_report.palette import camera_variable
from tacos_report.study_data import CameraResult
from tacos_report.view_geometry import Point, footprint, half_extents

_MARGIN = 0.7  # of the frame, shown around it for frames that reach beyond
_UNIT = 1000.0  # drawing units per focal length, so that coordinates stay readable


def footprints(cameras: Sequence[CameraResult], picture_uri: str) -> str:
    """SVG of the first camera's picture with the outlines of the other cameras' frames.

    Exact for cameras at the same place: a frame turns into a quadrilateral by the difference in pitch alone.
    Cameras whose field of view is not known, or whose frame leaves the picture far behind, are left out.

    `picture_uri`: data URI of the first camera's picture.
    """
    first, *others = cameras
    half_width, half_height = half_extents(first.derived["hfov_deg"], first.derived["vfov_deg"])
    outlines = [_outline(camera, first, index) for index, camera in enumerate(others, start=1)]
    drawn = [outline for outline in outlines if outline]
    corners = [corner for _, outline in drawn for corner in outline]
    right = min(half_width * (1 + _MARGIN), max([half_width, *(abs(x) for x, _ in corners)]) * 1.01)
    up = min(half_height * (1 + _MARGIN), max([half_height, *(-y for _, y in corners)]) * 1.01)
    down = min(half_height * (1 + _MARGIN), max([half_height, *(y for _, y in corners)]) * 1.01)
    view_box = " ".join(_n(value) for value in (-right, -up, 2 * right, up + down))
    stroke = 2 * right * _UNIT / 300
    frame = [(-half_width, -half_height), (half_width, -half_height)]
    frame += [(half_width, half_height), (-half_width, half_height)]
    shapes = [_polygon(outline, index, stroke, dashed=True) for index, outline in drawn]
    label = f"What the {first.title} sees"
    if drawn:
        label += ", with the frames of " + ", ".join(cameras[index].title for index, _ in drawn) + " outlined"
    return (
        f'<svg role="img" aria-label="{escape(label, quote=True)}" viewBox="{view_box}">'
        f'<image href="{picture_uri}" x="{_n(-half_width)}" y="{_n(-half_height)}" '
        f'width="{_n(2 * half_width)}" height="{_n(2 * half_height)}" preserveAspectRatio="none"/>'
        f"{_polygon(frame, 0, stroke * 1.4, dashed=False)}{''.join(shapes)}</svg>"
    )


def _outline(camera: CameraResult, first: CameraResult, index: int) -> tuple[int, list[Point]] | None:
    if not {"hfov_deg", "vfov_deg"} <= camera.derived.keys():
        return None
    extents = half_extents(camera.derived["hfov_deg"], camera.derived["vfov_deg"])
    corners = footprint(extents, camera.pitch_deg, first.pitch_deg)
    return (index, corners) if corners else None


def _polygon(corners: Sequence[Point], index: int, stroke: float, *, dashed: bool) -> str:
    points = " ".join(f"{_n(x)},{_n(y)}" for x, y in corners)
    dashes = f' stroke-dasharray="{stroke * 4:.1f} {stroke * 2.4:.1f}"' if dashed else ""
    halo = f'<polygon points="{points}" fill="none" stroke="var(--paper)" stroke-opacity=".8" '
    halo += f'stroke-width="{stroke * 2:.1f}"/>'
    line = f'<polygon points="{points}" fill="none" stroke="{camera_variable(index)}" '
    line += f'stroke-width="{stroke:.1f}"{dashes}/>'
    return (halo if dashed else "") + line


def _n(focal_lengths: float) -> str:
    return f"{focal_lengths * _UNIT:.1f}"
