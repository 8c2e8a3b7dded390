"""One camera on the agent."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from pydantic import model_validator

from tacos_framework import Constraint, Rig, setting
from tacos_plugins.rigs.lens import COVERED, LENS_UNITS, LensPart, derived_fit, notes_on_fit
from tacos_plugins.rigs.mounted_camera import (
    DERIVED_UNITS,
    MountSettings,
    ReadOutVariables,
    derived_optics,
    image_coordinates,
    mounted_camera,
)


class MonocularRig:
    """One camera, ``camera``, straight above the agent's eye, pitched up or down.

    Examples
    --------
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
        """What a recipe may design or fix; of focal length and lens exactly one."""

        pitch_deg: float = setting(
            0.0,
            help="Tilt of the camera, positive is up.",
            unit="deg",
            ge=-90,
            le=90,
            also=("tilt", "elevation"),
        )
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

        @model_validator(mode="after")
        def _one_of_focal_length_and_lens(self) -> MonocularRig.Variables:
            if (self.focal_length_mm is None) == (self.lens is None):
                found = "neither" if self.lens is None else "both"
                raise ValueError(f"give exactly one of focal_length_mm and lens, not {found}")
            return self

    derived_quantities: ClassVar[Mapping[str, str]] = {**DERIVED_UNITS, **LENS_UNITS}
    alternatives: ClassVar[tuple[tuple[str, ...], ...]] = (("focal_length_mm", "lens"),)
    buildable: ClassVar[tuple[Constraint, ...]] = (COVERED,)

    def __init__(self, config: Config) -> None:
        self.config = config

    def build(self, variables: Variables) -> Rig:
        """The rig of these variables."""
        camera = mounted_camera(
            "camera",
            variables,
            _focal_length_mm(variables),
            position_m=(0.0, 0.0, self.config.height_above_eye_m),
            pitch_deg=variables.pitch_deg,
            binning=self.config.binning,
        )
        return Rig((camera,))

    def derived(self, variables: Variables) -> Mapping[str, float]:
        """Fields of view and sizes of the sensor as manufactured, and how a lens fits it."""
        optics = derived_optics(variables.read_out, _focal_length_mm(variables))
        fit = {} if variables.lens is None else derived_fit(variables.lens, variables.read_out)
        return {**optics, **fit}

    def coordinates(self, variables: Variables) -> Mapping[str, float]:
        """What images depend on; see :func:`tacos_plugins.rigs.mounted_camera.image_coordinates`."""
        return image_coordinates(variables.read_out, _focal_length_mm(variables), variables.pitch_deg)

    def notes(self, variables: Variables) -> Iterator[str]:
        """What somebody who buys lens and sensor should know."""
        if variables.lens is not None:
            yield from notes_on_fit(variables.lens, variables.read_out)


def _focal_length_mm(variables: MonocularRig.Variables) -> float:
    if variables.lens is not None:
        return variables.lens.focal_length_mm
    assert variables.focal_length_mm is not None, "Variables holds exactly one of the two"
    return variables.focal_length_mm
