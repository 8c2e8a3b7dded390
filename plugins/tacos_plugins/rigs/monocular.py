"""One camera on the agent."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from pydantic import model_validator

from tacos_framework import Constraint, Rig, setting
from tacos_plugins.rigs.calibrated import calibrated_optics, refuse_beside
from tacos_plugins.rigs.calibration_files import CalibratedLens
from tacos_plugins.rigs.costs import COST_UNITS, derived_costs
from tacos_plugins.rigs.lens import COVERED, LENS_UNITS, LensPart, derived_fit, notes_on_fit
from tacos_plugins.rigs.mounted_camera import (
    DERIVED_UNITS,
    MountSettings,
    ReadOutVariables,
    derived_optics,
    image_coordinates,
    mounted_camera,
    tilt_of,
)
from tacos_plugins.rigs.optics import Optics, notes_on_circle
from tacos_plugins.rigs.product import (
    ProductPart,
    notes_on_product,
    refuse_beside_product,
    with_parts_of_product,
)


class MonocularRig:
    """One camera, ``camera``, straight above the agent's eye, pitched up or down.

    >>> builder = MonocularRig(MonocularRig.Config(binning=4))
    >>> flea3 = {"width_px": 4000, "height_px": 3000, "pixel_um": 1.55}
    >>> variables = MonocularRig.Variables(focal_length_mm=3.6, sensor=flea3)
    >>> camera = builder.build(variables).cameras[0]
    >>> camera.width_px, camera.height_px, round(camera.hfov_deg, 2)
    (1000, 750, 81.46)
    """

    class Config(MountSettings):
        """Settings of the rig."""

    class Variables(ReadOutVariables):
        """Variables that a recipe may design or fix; of focal length, lens, calibration and camera exactly
        one.
        """

        pitch_deg: float = tilt_of("the camera")
        focal_length_mm: float | None = setting(
            None,
            help="Focal length of a lens yet to be found, instead of a lens.",
            unit="mm",
            gt=0,
            also=("fov", "hfov", "vfov", "zoom", "efl"),
        )
        lens: LensPart | None = setting(
            None, help="Lens: a row of a catalog, or its focal length and what else is known of it."
        )

        calibration: CalibratedLens | None = setting(
            None,
            help="Calibration of its lens by OpenCV, ROS or Kalibr, instead of a focal length and a "
            "projection: a file, or its numbers.",
            is_path=True,
        )
        camera: ProductPart | None = setting(
            None, help="A whole camera with its sensor and lens: a row of a catalog, or what is known of it."
        )

        _parts_of_product = model_validator(mode="before")(with_parts_of_product)

        @model_validator(mode="after")
        def _one_of_focal_length_and_lens(self) -> MonocularRig.Variables:
            if self.camera is not None:
                refuse_beside_product(self, "focal_length_mm", "lens", "calibration")
                return self
            if self.calibration is not None:
                refuse_beside(self.calibration, self, "focal_length_mm", "lens")
                return self
            if (self.focal_length_mm is None) == (self.lens is None):
                found = "neither" if self.lens is None else "both"
                raise ValueError(f"give exactly one of focal_length_mm and lens, not {found}")
            if self.lens is not None:
                self.lens.optics(self.read_out, self.image_circle_deg)
            if self.lens is not None and self.projection != "rectilinear":
                raise ValueError("projection is the lens's own: leave it out, or give a focal_length_mm")
            return self

    derived_quantities: ClassVar[Mapping[str, str]] = {**DERIVED_UNITS, **LENS_UNITS, **COST_UNITS}
    alternatives: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("focal_length_mm", "lens", "calibration", "camera"),
        ("sensor", "camera"),
    )
    buildable: ClassVar[tuple[Constraint, ...]] = (COVERED,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def build(self, variables: Variables) -> Rig:
        camera = mounted_camera(
            "camera",
            variables,
            _optics(variables),
            position_m=(0.0, 0.0, self.config.height_above_eye_m),
            pitch_deg=variables.pitch_deg,
            binning=self.config.binning,
        )
        return Rig((camera,))

    def derived(self, variables: Variables) -> Mapping[str, float]:
        """Fields of view and sizes of the sensor as manufactured, how a lens fits it, and what it costs."""
        optics = derived_optics(variables.read_out, _optics(variables))
        fit = {} if variables.lens is None else derived_fit(variables.lens, variables.read_out)
        costs = derived_costs(variables, self.config, product=variables.camera, lens=variables.lens)
        return {**optics, **fit, **costs}

    def coordinates(self, variables: Variables) -> Mapping[str, float]:
        """Coordinates of images; see :func:`tacos_plugins.rigs.mounted_camera.image_coordinates`."""
        return image_coordinates(variables.read_out, _optics(variables), variables.pitch_deg)

    def notes(self, variables: Variables) -> Iterator[str]:
        """Notes for buyers of lens and sensor, or of a whole camera."""
        if variables.camera is not None:
            yield from notes_on_product(variables.camera)
        if variables.lens is not None:
            yield from notes_on_fit(variables.lens, variables.read_out)
        yield from notes_on_circle(_optics(variables), variables.read_out)


def _optics(variables: MonocularRig.Variables) -> Optics:
    if variables.camera is not None:
        return variables.camera.optics(variables.image_circle_deg)
    if variables.calibration is not None:
        return calibrated_optics(variables.calibration, variables)
    if variables.lens is not None:
        return variables.lens.optics(variables.read_out, variables.image_circle_deg)
    assert variables.focal_length_mm is not None, "Variables holds exactly one of the four"
    return Optics(variables.focal_length_mm, variables.projected())
