"""Figures that no camera has: most likely they are in another unit. Said before anything is rendered."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from tacos_framework.errors import CandidateFailed
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.notes import middle
from tacos_framework.plan.plan import Plan
from tacos_framework.values import Camera

_FEWEST_PX, _FEW_PX = 3, 32
"""Images smaller than the one mean nothing, and than the other little [px]."""
_PIXEL_UM, _FOCAL_MM, _HFOV_DEG, _EXPOSURE_MS = (0.3, 200.0), (0.1, 2000.0), (0.5, 175.0), (1e-4, 60_000.0)
"""Usual ranges of cameras, with room on both sides."""


def check_image_sizes(findings: RecipeFindings, plan: Plan) -> None:
    """Binning that leaves no image is a fault, as each candidate would fail by it."""
    values = middle(plan)
    own_px = plan.derived(values).get("image_width_px", 0) if values else 0
    for camera in _cameras(plan, values):
        if min(camera.width_px, camera.height_px) < _FEWEST_PX and own_px > _FEW_PX:
            size = f"{camera.width_px} x {camera.height_px}"
            what = f"{camera.simulated_binning:g} leaves an image of {size} pixels"
            findings.add(("rig", "binning"), what, "images of some hundred pixels", "Lower it.")
            return


def check_exposures(findings: RecipeFindings, plan: Plan) -> None:
    """No camera takes frames faster than it exposes them: none in this scene could."""
    if plan.exposure is not None:
        return
    longest_ms = max(scenario.exposure_ms for scenario in plan.recipe.scenarios)
    path: tuple[str, ...] = ("scenario", "exposure_ms")
    for variable in plan.space.variables:
        if variable.name.endswith(".exposure_ms"):
            path, known = ("design", variable.name), variable.as_data()
            longest_ms = max(known["values"] if "values" in known else [known["upper"]])
    for scene in plan.graph.of_kind("scene"):
        config = plan.nodes[scene].config
        rate_hz = getattr(config, "frame_rate_hz", None)
        follow = getattr(config, "sampling", "walk") in ("walk", "bursts")
        if rate_hz and follow and longest_ms > 1000 / rate_hz:
            findings.add(
                path,
                f"exposures of {longest_ms:g} ms are longer than the {1000 / rate_hz:.3g} ms from frame to "
                f"frame of {scene!r}",
                "exposures within the time of a frame",
                f"Shorten them, or give {scene!r} a frame_rate_hz of {1000 / longest_ms:.3g} or less.",
            )


def doubts_of_units(plan: Plan) -> Iterator[str]:
    """Sentences on figures of cameras and scenarios that are most likely in another unit."""
    seen = {"the middle of the design space": middle(plan)}
    seen |= {camera.title: {**middle(plan), **camera.fixes} for camera in plan.cameras}
    for title, values in seen.items():
        for camera in _cameras(plan, values):
            yield from (f"{title}, {camera.name}: {doubt}" for doubt in doubts_of_camera(camera))
    for scenario in plan.recipe.scenarios:
        exposure_ms = scenario.exposure_ms
        yield from filter(
            None, [_beyond("exposure_ms", exposure_ms, _EXPOSURE_MS, "seconds", "microseconds")]
        )


def doubts_of_camera(camera: Camera) -> Iterator[str]:
    """Implausible figures, with the likely unit.

    >>> camera = Camera("c", 640, 480, pixel_um=0.003, focal_length_mm=4.0)
    >>> list(doubts_of_camera(camera))
    ['pixel_um is 0.003, as of no camera; is it in millimetres? Then it is 3']
    """
    pitch = _beyond("pixel_um", camera.pixel_um, _PIXEL_UM, "millimetres", "nanometres")
    focal = _beyond("focal_length_mm", camera.focal_length_mm, _FOCAL_MM, "metres", "micrometres")
    yield from filter(None, (pitch, focal))
    if not (pitch or focal or _HFOV_DEG[0] <= camera.hfov_deg <= _HFOV_DEG[1]):
        wide_mm = camera.width_px * camera.pixel_um * camera.binning * 1e-3
        yield (
            f"focal_length_mm {camera.focal_length_mm:g} before {wide_mm:.3g} mm of pixels sees "
            f"{camera.hfov_deg:.3g} degrees; check both"
        )
    if min(camera.width_px, camera.height_px) < _FEW_PX and camera.simulated_binning > 1:
        size = f"{camera.width_px} x {camera.height_px}"
        yield f"binning {camera.simulated_binning:g} leaves an image of {size} pixels"


def _beyond(name: str, value: float, usual: tuple[float, float], larger: str, smaller: str) -> str:
    """A doubt about a value, with the unit a thousand times larger or smaller that would make it usual."""
    if usual[0] <= value <= usual[1]:
        return ""
    unit, likely = (larger, value * 1000) if value < usual[0] else (smaller, value / 1000)
    guess = f"; is it in {unit}? Then it is {likely:g}" if usual[0] <= likely <= usual[1] else ""
    return f"{name} is {value:g}, as of no camera{guess}"


def _cameras(plan: Plan, values: Mapping[str, Any]) -> tuple[Camera, ...]:
    """The cameras of a rig; none where it refuses the values."""
    try:
        with plan.rig.calling("build"):
            return tuple(plan.rig.instance.build(plan.rig_variables(values)).cameras)
    except (ValidationError, CandidateFailed):
        return ()
