"""Price of a camera's parts together, as far as their catalogs state it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tacos_report.plain_values import finite
from tacos_report.quantities import joined, number, words

_COLUMN = "price_"
"""How the column of a price begins; its currency follows, as in ``price_eur``."""

_DIGITS = 6
"""Significant digits of a price: cents up to a thousand."""


def price_words(camera: Mapping[str, Any]) -> str:
    r"""The sum of one of each part, with what it consists of; nothing where no price is stated.

    Currencies are not converted: each has a sum of its own.

    >>> sensor, lens = {"name": "A", "price_eur": 40.5}, {"name": "B", "price_eur": 210.0}
    >>> price_words({"sensor": sensor, "lens": lens}).replace("\u202f", " ")
    '250.5 EUR: sensor 40.5 EUR, lens 210 EUR'
    >>> price_words({"sensor": sensor, "focal_length_mm": 3.0}).replace("\u202f", " ")
    'at least 40.5 EUR: sensor 40.5 EUR; not stated of lens'
    """
    stated: dict[str, tuple[float, str]] = {}
    lacking = ["lens"] if "focal_length_mm" in camera and "lens" not in camera else []
    for variable, part in camera.items():
        if not isinstance(part, Mapping):
            continue
        if prices := [(value, name) for name in part if (value := _price(part, name)) is not None]:
            value, name = prices[0]
            stated[variable] = value, name.removeprefix(_COLUMN).upper()
        else:
            lacking.append(variable)
    if not stated:
        return ""
    sums: dict[str, float] = {}
    for value, currency in stated.values():
        sums[currency] = sums.get(currency, 0.0) + value
    total = " and ".join(_amount(value, currency) for currency, value in sums.items())
    each = ", ".join(f"{words(name).lower()} {_amount(*price)}" for name, price in stated.items())
    if lacking:
        return f"at least {total}: {each}; not stated of {', '.join(words(name).lower() for name in lacking)}"
    return f"{total}: {each}" if len(stated) > 1 else each


def _price(part: Mapping[str, Any], name: str) -> float | None:
    return finite(part[name]) if name.startswith(_COLUMN) else None


def _amount(value: float, currency: str) -> str:
    return joined(number(value, _DIGITS), currency)
