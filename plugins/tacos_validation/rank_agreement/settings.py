"""Measured agreement, its cameras and lights."""

from __future__ import annotations

from pydantic import JsonValue, model_validator

from tacos_framework import Settings, setting


class RankedCameras(Settings):
    """The cameras to rank, by up to three ways of naming them."""

    products: tuple[str, ...] = setting((), help="Names in the catalog of cameras off the shelf.")
    catalog: str = setting("cameras", help="That catalog: the name of a shipped one, or a path.")
    parts: tuple[str, ...] = setting(
        (), help="Names of parts in the catalog that the study chooses from; each makes a camera."
    )
    match: dict[str, dict[str, float]] = setting(
        {},
        help="For cameras made of parts, variables to solve for so that a derived quantity has a value, e.g. "
        "{focal_length_mm: {hfov_deg: 81.5}}.",
    )
    by_values: dict[str, dict[str, JsonValue]] = setting(
        {}, help="Cameras by name, with the values of their design variables."
    )
    at: dict[str, JsonValue] = setting(
        {}, help="Values of the variables that a camera leaves free, e.g. {pitch_deg: -20}."
    )

    @model_validator(mode="after")
    def _can_be_ranked(self) -> RankedCameras:
        names = [*self.products, *self.parts, *self.by_values]
        if len(names) < 2:
            raise ValueError("an order needs two cameras at least")
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"{', '.join(twice)} named more than once")
        for variable, quantity in self.match.items():
            if len(quantity) != 1:
                raise ValueError(f"match.{variable} takes one derived quantity and its value")
        return self


class RankAgreementConfig(Settings):
    study: str = setting(
        help="The recipe of the small study: a path, or the name of a shipped one.", is_path=True
    )
    change: dict[str, JsonValue] = setting({}, help="Keys of that recipe to change, as with --set.")
    full: dict[str, JsonValue] = setting(
        help="Keys that make it the study at full size, e.g. {rig.binning: 1}.", min_length=1
    )
    lights: dict[str, dict[str, JsonValue]] = setting(
        help="For each light by name the keys it changes, e.g. {scenario.illumination_lux: 2}.", min_length=1
    )
    cameras: RankedCameras = setting(help="The cameras to rank.")
    scenes: int | None = setting(None, help="Scenes to score them on; by default those of the study.", ge=1)
    gate: float = setting(0.8, help="Smallest Kendall's tau-b at which the orders agree.", gt=-1, le=1)
    fewest: int = setting(10, help="Fewer cameras with a place in both orders decide nothing.", ge=2)
    confidence: float = setting(0.95, help="Confidence of the intervals of tau.", gt=0, lt=1)
    resamples: int = setting(1000, help="Draws of scenes behind the intervals.", ge=10)
