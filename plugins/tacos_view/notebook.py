"""Cameras in notebooks: ``%load_ext tacos`` shows `Camera` and `Rig` as a drawing with their figures."""

from __future__ import annotations

import math
from typing import Any

from tacos_framework import Camera, Rig

_REACH, _EDGE = 80.0, 8.0


def load_ipython_extension(ipython: Any) -> None:
    """Have IPython show cameras and rigs; called by ``%load_ext tacos``."""
    html = ipython.display_formatter.formatters["text/html"]
    html.for_type(Camera, camera_html)
    html.for_type(Rig, rig_html)


def camera_html(camera: Camera) -> str:
    return f"<figure>{_field_of_view(camera)}<figcaption>{camera._repr_html_()}</figcaption></figure>"


def rig_html(rig: Rig) -> str:
    drawn = "".join(map(_field_of_view, rig.cameras))
    return f"<figure>{drawn}<figcaption>{rig._repr_html_()}</figcaption></figure>"


def _field_of_view(camera: Camera) -> str:
    half = math.radians(camera.hfov_deg) / 2
    x, y = _REACH * math.sin(half), _REACH * math.cos(half)
    apex = _REACH + _EDGE
    rim = f"l {-x:.1f} {-y:.1f} A {_REACH} {_REACH} 0 0 1 {apex + x:.1f} {apex - y:.1f}"
    wedge = f"M {apex:.1f} {apex:.1f} {rim} Z"
    return (
        f'<svg width="{2 * apex:.0f}" height="{apex + _EDGE:.0f}" role="img" aria-label="field of view">'
        f'<path d="{wedge}" fill="#0072b2" fill-opacity="0.2" stroke="#0072b2"/></svg>'
    )
