"""Lists the components of this package; imports none of them."""

from __future__ import annotations

from tacos_framework import Component, hookimpl


@hookimpl
def tacos_components() -> list[Component]:
    """What this package offers."""
    return [
        Component(
            "scene",
            "qr-shelf",
            "tacos_qr_codes.shelf:QrShelf",
            summary="A shelf with QR codes that the agent passes sideways.",
            requires=("cv2=opencv-python-headless",),
        ),
        Component(
            "task",
            "qr-codes",
            "tacos_qr_codes.reading:QrCodes",
            summary="Share of the QR codes of a world that are read on the way past them.",
            requires=("cv2=opencv-python-headless",),
        ),
    ]
