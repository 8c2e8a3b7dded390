"""The base of every component's ``Config``."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Settings(BaseModel):
    """Settings of a component: frozen, unknown keys refused, no NaN, no silent conversion.

    Each field is declared with :func:`setting`, so that checks, error messages, the settings reference
    and the JSON Schema for editors come from one place.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        arbitrary_types_allowed=False,
        validate_default=True,
        hide_input_in_errors=False,
    )


def setting(default: Any = ..., *, help: str, unit: str = "1", **bounds: Any) -> Any:
    """Declare one setting.

    Parameters
    ----------
    default
        The default value; leave out for a setting the user must give.
    help
        One sentence that says what the setting does.
    unit
        Its unit (``"m"``, ``"deg"``); ``"1"`` for a plain number, a name or a switch.
    bounds
        pydantic's ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``max_length``.
    """
    return Field(default, description=help, json_schema_extra={"unit": unit}, **bounds)
