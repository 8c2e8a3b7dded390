"""An effect's lengths and charges in the pixels and digital numbers of the image it acts on."""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import ValidationError

from tacos_framework.camera.exposure import gain_factor
from tacos_framework.camera.units import CHARGE_UNITS, LENGTH_UNITS, binned, image_units_per
from tacos_framework.errors import CandidateFailed
from tacos_framework.settings import Settings, averaging_of, includes_pedestal, physical_settings, unit_of
from tacos_framework.values import ImageContext, ImageGeometry


def in_image_units(config: Settings, use: str, geometry: ImageGeometry, context: ImageContext) -> Settings:
    """Settings with every physical value turned into that of an image, and binning taken account of.

    `config`: settings of an effect, in physical units or in those of photosites. `use`: the component, for
    messages.

    Returns: in pixels and digital numbers of the image alone; `config` itself where that is what it has.

    Raises `CandidateFailed` where a value is out of bounds there, or the camera's conversion gain is not
    known.
    """
    photosites = _in_photosites(_at_gain(config, context), use, geometry, context)
    if geometry.binning == 1.0:
        return photosites
    kind = type(config)
    values = {name: getattr(photosites, name) for name in _of_photosites(kind)}
    changed = {
        name: value * binned(unit_of(kind, name), averaging_of(kind, name), geometry.binning)
        for name, value in values.items()
        if value is not None
    }
    # Bounds are those of photosites: in binned pixels a length may well be shorter.
    return photosites.model_copy(update=changed) if changed else photosites


def _at_gain(config: Settings, context: ImageContext) -> Settings:
    """Settings whose digital numbers stand for charges, from the gain they are given at to the image's."""
    if context.charges_at_db in (None, context.gain_db):
        return config
    factor, kind = gain_factor(context.gain_db - context.charges_at_db), type(config)
    changed = {}
    for name, image_name in physical_settings(kind).items():
        if unit_of(kind, name) in CHARGE_UNITS and (value := getattr(config, image_name)) is not None:
            pedestal = context.black_level_dn if includes_pedestal(kind, image_name) else 0.0
            changed[image_name] = pedestal + (value - pedestal) * factor
    return config.model_copy(update=changed)


def _in_photosites(config: Settings, use: str, geometry: ImageGeometry, context: ImageContext) -> Settings:
    """Settings with physical values turned into pixels and digital numbers of the camera's photosites."""
    kind = type(config)
    changed: dict[str, Any] = {}
    for name, image_name in physical_settings(kind).items():
        value = getattr(config, name)
        if value is None:
            continue
        unit = unit_of(kind, image_name)
        per = image_units_per(unit_of(kind, name), unit, geometry=geometry, context=context)
        if per is None:
            raise CandidateFailed(
                f"{use} has {name} = {value:g} {unit_of(kind, name)}, but how many DN an electron makes on "
                f"camera {geometry.camera!r} is not known: give {image_name} instead"
            )
        pedestal = context.black_level_dn if includes_pedestal(kind, image_name) else 0.0
        changed |= {name: None, image_name: value * per + pedestal}
    if not changed:
        return config
    values = {name: getattr(config, name) for name in kind.model_fields}
    try:
        return kind(**{**values, **changed})
    except ValidationError as error:
        first = error.errors()[0]
        raise CandidateFailed(
            f"{use} on camera {geometry.camera!r}: {'.'.join(map(str, first['loc']))} comes to "
            f"{first['input']}: {first['msg']}"
        ) from error


@cache
def _of_photosites(kind: type[Settings]) -> tuple[str, ...]:
    """Settings that binning changes."""
    return tuple(
        name
        for name, field in kind.model_fields.items()
        if unit_of(kind, name) in LENGTH_UNITS or averaging_of(kind, name)
        if field.annotation in (float, int, float | None)
    )
