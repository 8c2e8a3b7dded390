"""The base of every component's ``Config``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, JsonValue, model_validator

Averaging = Literal["photosites", "lines"]
"""Independent entries of a spread, which average out in a binned pixel: photosites, or rows or columns."""


class Settings(BaseModel):
    """Settings of a component: frozen, unknown keys refused, no NaN.

    Each field is declared with :func:`setting`, so that checks, error messages, the settings reference
    and the JSON Schema for editors come from one place.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True)

    retired_keys: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Keys that there were once, and what to do instead: the remedy where one of them is given."""

    @model_validator(mode="after")
    def _one_of_image_and_physical(self) -> Self:
        for name, image in physical_settings(type(self)).items():
            given, other = getattr(self, name), getattr(self, image)
            if given is not None and other != type(self).model_fields[image].default:
                raise ValueError(f"{image} and {name} exclude each other: give one of the two")
        return self


def setting(
    default: Any = ...,
    *,
    help: str,
    unit: str = "1",
    is_path: bool = False,
    averaging: Averaging | None = None,
    with_pedestal: bool = False,
    period: float | None = None,
    also: Sequence[str] = (),
    **bounds: Any,
) -> Any:
    """Declare one setting.

    - `default`: the default value; leave out for a setting the user must give.
    - `help`: one sentence that says what the setting does.
    - `unit`: its unit (``"m"``, ``"deg"``); ``"1"`` for a plain number, a name or a switch.
    - `is_path`: whether text given for it may be a path; a recipe's relative paths start from its own folder.
    - `averaging`: for the spread of something: what in it is independent. Binning then makes it smaller.
    - `with_pedestal`: for a level in digital numbers: whether it includes the pedestal.
    - `period`: for an angle: after how much it means the same again. Estimates are given from 0 to it.
    - `also`: what others call it, words in lower case: whoever writes one of them is told this name.
    - `bounds`: pydantic's ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``max_length``, ``alias``.
    """
    extra: dict[str, JsonValue] = {"unit": unit}
    if is_path:
        extra["path"] = True
    if averaging:
        extra["averaging"] = averaging
    if with_pedestal:
        extra["with_pedestal"] = True
    if period is not None:
        extra["period"] = period
    if also:
        extra["also_called"] = list(also)
    return Field(default, description=help, json_schema_extra=extra, **bounds)


def physical(of: str, *, help: str, unit: str, **bounds: Any) -> Any:
    """Declare the physical counterpart of a setting in pixels or digital numbers; nothing unless given.

    A length on the sensor in um means the same for every pitch, a charge in e- for every gain, where pixels
    and digital numbers are those of one camera. The two exclude each other.

    - `of`: the setting in pixels (``px``) or digital numbers (``DN``, ``DN/s``) that it stands for.
    - `help`: one sentence that says what it does.
    - `unit`: ``um`` or ``deg/s`` for pixels, ``e-`` for DN, ``e-/s`` for DN/s, ``of full scale`` for DN of a
      file.
    - `bounds`: as of :func:`setting`.
    """
    extra: dict[str, JsonValue] = {"unit": unit, "physical_of": of}
    return Field(None, description=help, json_schema_extra=extra, **bounds)


def unit_of(config: type[BaseModel], name: str) -> str:
    """The unit of a setting; ``"1"`` for a plain number, a name or a switch."""
    return str(_extra(config, name).get("unit", "1"))


def averaging_of(config: type[BaseModel], name: str) -> Averaging | None:
    """Independent entries of a spread, as :func:`setting` declared them."""
    found: Any = _extra(config, name).get("averaging")
    return found


def includes_pedestal(config: type[BaseModel], name: str) -> bool:
    """True if a level counts from 0 DN, not from the pedestal."""
    return bool(_extra(config, name).get("with_pedestal"))


def period_of(config: type[BaseModel], name: str) -> float | None:
    """After how much a setting means the same again; None where it never does."""
    period: Any = _extra(config, name).get("period")
    return period


def also_called(config: type[BaseModel]) -> dict[str, tuple[str, ...]]:
    """Other names of the settings of a class, by the names they are given by."""
    words: Any = {
        field.alias or name: _extra(config, name).get("also_called", ())
        for name, field in config.model_fields.items()
    }
    return {name: tuple(called) for name, called in words.items() if called}


@cache
def physical_settings(config: type[BaseModel]) -> Mapping[str, str]:
    """The physical settings of a class, each with the one in pixels or digital numbers it stands for."""
    counterparts = {name: _extra(config, name).get("physical_of") for name in config.model_fields}
    return MappingProxyType({name: str(of) for name, of in counterparts.items() if of})


def path_settings(config: type[Settings]) -> list[str]:
    """The settings that may be paths."""
    return [name for name in config.model_fields if _extra(config, name).get("path")]


def paths_in(settings: Settings) -> Iterator[tuple[str, str]]:
    """The settings that may be paths and that text is given for, by name."""
    for name in path_settings(type(settings)):
        value = getattr(settings, name)
        if isinstance(value, str) and value:
            yield name, value


def _extra(config: type[BaseModel], name: str) -> Mapping[str, JsonValue]:
    extra = config.model_fields[name].json_schema_extra
    return extra if isinstance(extra, dict) else {}


def with_paths_from(
    folder_of: Callable[[str], Path | None], config: type[Settings], settings: Mapping[str, Any]
) -> dict[str, Any]:
    """The settings, with relative paths to what exists below the folder of a setting made to start there."""
    found = dict(settings)
    for name in path_settings(config):
        value = settings.get(name)
        if isinstance(value, str) and value:
            folder = folder_of(name)
            if folder is not None and (folder / value).exists():
                found[name] = str(folder / value)
    return found
