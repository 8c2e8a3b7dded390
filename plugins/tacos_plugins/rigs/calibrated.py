"""A camera with the lens of a calibration."""

from __future__ import annotations

from dataclasses import replace

from tacos_plugins.rigs.calibration_files import CalibratedLens
from tacos_plugins.rigs.mounted_camera import ReadOutVariables
from tacos_plugins.rigs.optics import Optics


def refuse_beside(calibration: CalibratedLens, variables: ReadOutVariables, *others: str) -> None:
    """Refuse other words on the lens beside a calibration, or one of other images than those read out.

    Raises `ValueError` with what to change.
    """
    if twice := [name for name in others if getattr(variables, name) is not None]:
        raise ValueError(f"calibration and {twice[0]} both say the focal length: give one of the two")
    if variables.projection != "rectilinear":
        raise ValueError("calibration brings a projection of its own: leave projection out")
    size, read_out = (calibration.width_px, calibration.height_px), variables.read_out
    if size != (read_out.width_px, read_out.height_px):
        raise ValueError(
            f"calibration {calibration.title} is of images of {size[0]} x {size[1]} pixels, and this camera "
            f"reads out {read_out.width_px} x {read_out.height_px}: calibrate with these, or choose the "
            f"sensor, region and binning that it was calibrated with"
        )
    calibrated_optics(calibration, variables)


def calibrated_optics(calibration: CalibratedLens, variables: ReadOutVariables) -> Optics:
    """The optics that were calibrated, for the pixels that are read out."""
    lens = calibration.lens
    if variables.image_circle_deg is not None:
        lens = replace(lens, half_field_deg=variables.image_circle_deg / 2)
    focal_length_mm = calibration.focal_length_px * variables.read_out.pixel_um * 1e-3
    return Optics(focal_length_mm, lens, calibration.centre_px)
