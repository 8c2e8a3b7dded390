"""The procedure."""

from __future__ import annotations

from tacos_framework.testing import ProcedureConformance

from tacos_example.preview import Preview


class TestPreview(ProcedureConformance):
    component = Preview
    config = {
        "scene": {"use": "scene.corridor"},
        "renderer": {"use": "renderer.integrating-sphere"},
        "width_px": 32,
    }
    files = ("preview.png",)
