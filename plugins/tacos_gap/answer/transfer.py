"""Transfer to other cameras: parameters in physical units, and effects for a recipe."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tacos_framework import ImageContext, ImageGeometry, Settings, to_yaml, unit_of
from tacos_gap.answer.findings import Cause, Parameter, Physical, as_fine_as, short
from tacos_gap.answer.physical_settings import physical_settings_of
from tacos_gap.captures import RealCapture
from tacos_gap.captures.capture import usual_gain_db
from tacos_gap.simulation.sensors import sensor_at

HEAD = "# Effects that close the gap; add them to a recipe: tacos-run RECIPE --with patched.yaml\n"


@dataclass(frozen=True)
class Photographed:
    """The camera of captures, under which pixels and digital numbers are what they are."""

    geometry: ImageGeometry
    """Of the capture that stands for all: lengths of motion hold at its exposure, levels at its gain."""
    context: ImageContext

    @classmethod
    def of(cls, captures: Sequence[RealCapture]) -> Photographed:
        """By the captures at the gain most were taken at, one that shows edges where there is one.

        Where noise was estimated, each capture has a conversion gain of its own: the middle one counts.
        """
        usual_db = usual_gain_db(captures)
        chosen = [capture for capture in captures if capture.context.gain_db == usual_db]
        shown = sorted(chosen, key=lambda c: (not c.is_structured, c.kind == "dark"))
        known = [gain for c in chosen if (gain := sensor_at(c).context.dn_per_electron)]
        gain = float(np.median(known)) if known else None
        return cls(shown[0].geometry, replace(shown[0].context, dn_per_electron=gain))

    def in_physical_units(self, kind: type[Settings], parameter: Parameter, name: str) -> Parameter:
        def turned(value: Any) -> tuple[str, float] | None:
            return physical_settings_of(kind, {name: value}, self.geometry, self.context).get(name)

        if (found := turned(parameter.value)) is None:
            return parameter
        own, value = found
        ends = None
        if parameter.interval is not None:
            low, high = (e[1] for end in parameter.interval if (e := turned(end)) is not None)
            half = abs(high - low) / 2
            ends = as_fine_as(half, low), as_fine_as(half, high)
            value = as_fine_as(half, value)
        return replace(parameter, physical=Physical(own, short(value), ends, unit_of(kind, own)))

    def __str__(self) -> str:
        gain = f"{self.context.gain_db:g} dB, files up to {self.context.white_level_dn:g} DN"
        return f"a camera with pixels of {self.geometry.pixel_um:g} um at {gain}"


@dataclass(frozen=True)
class Added:
    """A cause as an effect of a recipe for any camera."""

    use: str
    settings: Mapping[str, Any]  # in physical units where it has them
    bound: tuple[str, ...] = ()  # settings that hold for the captured camera alone
    left_out: tuple[str, ...] = ()  # settings that belong to one specimen


def added(cause: Cause) -> Added:
    settings: dict[str, Any] = {}
    bound = []
    for name, value in cause.settings.items():
        if name in cause.specimen:
            continue
        parameter = cause.parameters[name]
        if parameter.physical is not None:
            settings[parameter.physical.name] = parameter.physical.value
            continue
        settings[name] = value
        if parameter.unit.startswith(("px", "row", "DN")):
            bound.append(name)
    return Added(f"effect.{cause.effect}", settings, tuple(bound), cause.specimen)


def patch(causes: Sequence[Cause]) -> list[dict[str, Any]]:
    return [{"use": entry.use, **entry.settings} for entry in map(added, causes)]


def of_specimen(kind: type[Settings], name: str) -> bool:
    """True if a setting names a file: what was measured on one camera belongs to it alone."""
    extra = kind.model_fields[name].json_schema_extra if name in kind.model_fields else None
    return isinstance(extra, dict) and bool(extra.get("path"))


def of_one_specimen(cause: Cause) -> str:
    """Reason why settings of a cause are not handed on, in a sentence."""
    names = ", ".join(cause.specimen)
    return f"effect.{cause.effect}, {names}: measured on one specimen, which no other camera has."


def of_each_capture(cause: Cause) -> list[str]:
    """For each parameter that every capture has a value of, what is handed on of it, in a sentence."""
    return [
        f"effect.{cause.effect}, {name}: the camera set it anew for each capture "
        f"({', '.join(f'{capture} {own.value:.3g}' for capture, own in parameter.by_capture.items())}"
        f" {parameter.unit}); patched.yaml has their median, {parameter.value:.3g} {parameter.unit}."
        for name, parameter in cause.parameters.items()
        if parameter.by_capture
    ]


def patched(causes: Sequence[Cause], camera: Photographed) -> str:
    """``patched.yaml``: the causes as effects of a recipe, with what does not transfer said."""
    if not causes:
        return f"{HEAD}[]\n"
    text = HEAD
    for cause in causes:
        entry = added(cause)
        if not cause.is_proven:
            text += f"# Fits, but is not proven: {cause.present:.0%}. Something else may look like it.\n"
        if cause.alike:
            text += f"# It or {' or '.join(cause.alike)}: these captures do not tell which.\n"
        if entry.left_out:
            text += f"# Left out. {of_one_specimen(cause)}\n"
        if entry.bound:
            text += f"# {', '.join(entry.bound)}: as of {camera}; not known in physical units.\n"
        text += to_yaml([{"use": entry.use, **entry.settings}], flow_style=None)
    return text
