"""Two parallel cameras a baseline apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import ClassVar

from pydantic import model_validator

from tacos_framework import Rig, setting
from tacos_plugins.rigs.calibrated import calibrated_optics, refuse_beside
from tacos_plugins.rigs.calibration_files import CalibratedLens
from tacos_plugins.rigs.costs import COST_UNITS, derived_costs
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
    StereoProduct,
    notes_on_product,
    refuse_beside_product,
    with_parts_of_product,
)

_SAME_BASELINE = 0.01
"""Share by which a baseline may differ from that of a calibration without a note [1]."""


class StereoRig:
    """Two equal, parallel cameras, ``left`` and ``right``, symmetric about the agent's eye.

    Rows of the two images correspond without rectification: a point at depth Z lies ``f B / Z`` pixels
    further left in the right image, f being the focal length in pixels and B the baseline.

    >>> builder = StereoRig(StereoRig.Config())
    >>> sensor = {"width_px": 991, "height_px": 495, "pixel_um": 1.55}  # the paper's stereo camera
    >>> rig = builder.build(StereoRig.Variables(baseline_m=0.12, hfov_deg=72, sensor=sensor))
    >>> [(camera.name, camera.agent_from_camera[1, 3].item()) for camera in rig.cameras]
    [('left', 0.06), ('right', -0.06)]
    """

    class Config(MountSettings):
        """Settings of the rig."""

    class Variables(ReadOutVariables):
        """Variables that a recipe may design or fix; of field of view and focal length exactly one."""

        baseline_m: float = setting(
            help="Distance between the two optical centres.",
            unit="m",
            gt=0,
            also=("eye_distance", "separation"),
        )
        hfov_deg: float | None = setting(
            None,
            help="Horizontal field of view, instead of a focal length.",
            unit="deg",
            gt=0,
            lt=360,
            also=("fov", "hfov"),
        )
        focal_length_mm: float | None = setting(
            None,
            help="Focal length of both lenses, instead of a field of view.",
            unit="mm",
            gt=0,
            also=("vfov", "zoom", "efl"),
        )
        calibration: CalibratedLens | None = setting(
            None,
            help="Calibration of either lens by OpenCV, ROS or Kalibr (of a chain, its first camera), "
            "instead of a field of view and a projection: a file, or its numbers.",
            is_path=True,
        )
        pitch_deg: float = tilt_of("both cameras")

        camera: StereoProduct | None = setting(
            None, help="A whole stereo camera: a row of a catalog, or what is known of it."
        )

        _parts_of_product = model_validator(mode="before")(with_parts_of_product)

        @model_validator(mode="after")
        def _one_of_field_and_focal_length(self) -> StereoRig.Variables:
            if self.camera is not None:
                refuse_beside_product(self, "hfov_deg", "focal_length_mm", "calibration")
                return self
            if self.calibration is not None:
                refuse_beside(self.calibration, self, "hfov_deg", "focal_length_mm")
                return self
            given = {"hfov_deg": self.hfov_deg, "focal_length_mm": self.focal_length_mm}
            if sum(value is not None for value in given.values()) != 1:
                found = ", ".join(f"{name}={value}" for name, value in given.items())
                raise ValueError(f"give exactly one of hfov_deg and focal_length_mm, not {found}")
            if self.hfov_deg is not None:
                self.optics_for("hfov_deg", self.read_out.width_mm)
            return self

    derived_quantities: ClassVar[Mapping[str, str]] = {**DERIVED_UNITS, **COST_UNITS, "baseline_m": "m"}
    alternatives: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("hfov_deg", "focal_length_mm", "calibration", "camera"),
        ("sensor", "camera"),
        ("baseline_m", "camera"),
    )

    def __init__(self, config: Config) -> None:
        self.config = config

    def build(self, variables: Variables) -> Rig:
        """The rig of these variables, left camera first."""
        half_m = variables.baseline_m / 2
        return Rig(
            tuple(
                mounted_camera(
                    name,
                    variables,
                    _optics(variables),
                    position_m=(0.0, left_m, self.config.height_above_eye_m),
                    pitch_deg=variables.pitch_deg,
                    binning=self.config.binning,
                )
                for name, left_m in (("left", half_m), ("right", -half_m))
            )
        )

    def derived(self, variables: Variables) -> Mapping[str, float]:
        """Fields of view and sizes of one sensor as manufactured, the baseline, and costs of both cameras."""
        optics = derived_optics(variables.read_out, _optics(variables))
        costs = derived_costs(variables, self.config, cameras=2, product=variables.camera)
        return {**optics, **costs, "baseline_m": variables.baseline_m}

    def notes(self, variables: Variables) -> Iterator[str]:
        """Notes for buyers of a whole camera, on a chain of others, and on the dark part of images."""
        if variables.camera is not None:
            yield from notes_on_product(variables.camera)
        chain, given_m = variables.calibration, variables.baseline_m
        if chain and not math.isclose(chain.baseline_m or given_m, given_m, rel_tol=_SAME_BASELINE):
            yield (
                f"The cameras of {chain.title} are {chain.baseline_m:.3g} m apart, and baseline_m is "
                f"{given_m:.3g} m. Both cameras have the first lens of that file."
            )
        yield from notes_on_circle(_optics(variables), variables.read_out)

    def coordinates(self, variables: Variables) -> Mapping[str, float]:
        """Coordinates of images of either camera, and the baseline, which counts by its ratios."""
        one = image_coordinates(variables.read_out, _optics(variables), variables.pitch_deg)
        return {"log2_baseline_m": math.log2(variables.baseline_m), **one}


def _optics(variables: StereoRig.Variables) -> Optics:
    if variables.camera is not None:
        return variables.camera.optics(variables.image_circle_deg)
    if variables.calibration is not None:
        return calibrated_optics(variables.calibration, variables)
    if variables.focal_length_mm is not None:
        return Optics(variables.focal_length_mm, variables.projected())
    return variables.optics_for("hfov_deg", variables.read_out.width_mm)
