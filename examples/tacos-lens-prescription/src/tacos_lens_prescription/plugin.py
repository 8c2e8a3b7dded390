"""Lists the components of this package; imports none of them."""

from __future__ import annotations

from tacos_framework import Component, hookimpl


@hookimpl
def tacos_components() -> list[Component]:
    """What this package offers."""
    return [
        Component(
            "effect",
            "prescription-distortion",
            "tacos_lens_prescription.distortion:PrescriptionDistortion",
            summary="Distortion of a lens, traced through its prescription.",
        ),
        Component(
            "effect",
            "prescription-image",
            "tacos_lens_prescription.image:PrescriptionImage",
            summary="Fall-off and blur of a lens over the field, traced through its prescription.",
        ),
    ]
