"""Cameras in notebooks: ``%load_ext tacos`` shows `Camera` and `Rig` as a drawing with their figures."""

from __future__ import annotations

import math
from typing import Any

from tacos_framework.values import Camera, Rig

_REACH, _EDGE = 80.0, 8.0


def load_ipython_extension(ipython: Any) -> None:
    """Have IPython show cameras and rigs; called by ``%load_ext tacos``."""
    html = ipython.display_formatter.formatters["text/html"]
    html.for_type(Camera, camera_html)
    html.for_type(Rig, rig_html)


def camera_html(camera: Camera) -> str:
    """The field of view of a camera from above, and its figures."""
    half = math.radians(camera.hfov_deg) / 2
    x, y = _REACH * math.sin(half), _REACH * math.cos(half)
    apex = _REACH + _EDGE
    rim = f"l {-x:.1f} {-y:.1f} A {_REACH} {_REACH} 0 0 1 {apex + x:.1f} {apex - y:.1f}"
    wedge = f"M {apex:.1f} {apex:.1f} {rim} Z"
    svg = (
        f'<svg width="{2 * apex:.0f}" height="{apex + _EDGE:.0f}" role="img" aria-label="field of view">'
        f'<path d="{wedge}" fill="#0072b2" fill-opacity="0.2" stroke="#0072b2"/></svg>'
    )
    said = (
        f"{camera.name}: {camera.width_px} x {camera.height_px} pixels of "
        f"{camera.pixel_um * camera.binning:g} um, {camera.focal_length_mm:.3g} mm, "
        f"{camera.hfov_deg:.1f} x {camera.vfov_deg:.1f} deg"
    )
    return f"<figure>{svg}<figcaption>{said}</figcaption></figure>"


def rig_html(rig: Rig) -> str:
    """The cameras of a rig, one below the other."""
    return "".join(map(camera_html, rig.cameras))
