"""A whole camera that can be bought: its sensor, its lens and what it costs, as one choice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from pydantic import model_validator

from tacos_framework import CatalogPart, Lens, Projection, setting
from tacos_plugins.rigs.mounted_camera import ReadOutVariables
from tacos_plugins.rigs.optics import Optics, optics_for
from tacos_plugins.rigs.sensor_part import SensorPart


class ProductPart(SensorPart):
    """The columns of a catalog of whole cameras a rig needs: those of a sensor, and these."""

    takes: ClassVar[str] = "mono"

    kind: str | None = setting(None, help="mono, stereo or multi; what its rig takes if absent.")
    sensor: str | None = setting(None, help="Name of its image sensor, if known.")
    hfov_deg: float | None = setting(
        None, help="Horizontal field of view; that of its focal length if absent.", unit="deg", gt=0, lt=360
    )
    focal_length_mm: float | None = setting(
        None, help="Focal length; counts where no field of view is given.", unit="mm", gt=0
    )
    f_number: float | None = setting(
        None, help="Focal length over aperture; that of the scenario if absent.", gt=0
    )
    projection: Projection | None = setting(None, help="That of its lens; rectilinear if absent.")
    baseline_mm: float | None = setting(None, help="Distance between its two cameras.", unit="mm", gt=0)
    mass_g: float | None = setting(None, help="Mass of the whole, if known.", unit="g", gt=0)
    interface: str | None = setting(None, help="Its interface, if known.")

    @model_validator(mode="after")
    def _can_be_simulated(self) -> ProductPart:
        if self.kind not in (None, self.takes):
            raise ValueError(f"its kind is {self.kind}, not {self.takes}")
        if self.hfov_deg is None and self.focal_length_mm is None:
            raise ValueError("neither hfov_deg nor focal_length_mm is known")
        if self.takes == "stereo" and self.baseline_mm is None:
            raise ValueError("baseline_mm is not known")
        self.optics()
        return self

    def optics(self, image_circle_deg: float | None = None) -> Optics:
        """Its lens, with which its sensor shows the field of view, or that of the focal length.

        Raises `ValueError` where the projection has no such field of view, or image circle.
        """
        half_deg = None if image_circle_deg is None else image_circle_deg / 2
        lens = Lens(self.projection or "rectilinear", half_field_deg=half_deg)
        if self.hfov_deg is not None:
            return optics_for(self.width_mm, self.hfov_deg, lens)
        assert self.focal_length_mm is not None, "one of the two is known"
        return Optics(self.focal_length_mm, lens)


class StereoProduct(ProductPart):
    """The same of two cameras in one housing."""

    takes: ClassVar[str] = "stereo"


def with_parts_of_product(given: Any) -> Any:
    """Variables of a rig with the sensor, and the baseline, of the product among them.

    Raises `ValueError` where the product and what it brings are both given.
    """
    camera = given.get("camera") if isinstance(given, Mapping) else None
    row = camera.as_dict() if isinstance(camera, CatalogPart) else camera
    if not isinstance(row, Mapping):
        return given
    known: dict[str, Any] = {name: value for name, value in row.items() if value is not None}
    own: dict[str, Any] = {"sensor": {**known, "name": known.get("sensor") or known.get("name", "custom")}}
    if "baseline_mm" in known:
        own["baseline_m"] = known["baseline_mm"] * 1e-3
    if twice := sorted(name for name in own if given.get(name) is not None):
        raise ValueError(f"give camera or {' and '.join(twice)}, not both: a camera brings its own")
    return {**given, **own}


def refuse_beside_product(variables: ReadOutVariables, *others: str) -> None:
    """Refuse what a product brings itself, where it is given beside one.

    Raises `ValueError` with what to leave out.
    """
    twice = [name for name in others if getattr(variables, name) is not None]
    twice += ["projection"] if variables.projection != "rectilinear" else []
    if twice:
        raise ValueError(f"give camera or {twice[0]}, not both: a camera brings its own")


def notes_on_product(camera: ProductPart) -> Iterator[str]:
    """Notes on the stated and the unstated figures of a product."""
    if camera.f_number is None:
        yield f"Not published: the f-number of {camera.name}; images are simulated at that of the scenario."
    else:
        yield f"Images of {camera.name} are simulated at f/{camera.f_number:g}, as its maker states."
    figures = {"price": camera.prices, "mass": camera.mass_g, "power": camera.power_w}
    if unknown := [name for name, value in figures.items() if not value]:
        yield f"Not published: {', '.join(unknown)} of {camera.name}."
