"""Parts with prices, and what several of them cost together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import model_validator

from tacos_framework import CURRENCIES, CatalogPart, Settings, setting

PRICE = "price_"
"""Beginning of the column of a price; its currency follows."""

_NO_PRICES = ("price_date",)


class PricedPart(Settings):
    """A part with prices in one or more currencies, in columns such as ``price_eur``."""

    prices: dict[str, float] = setting({}, help="Its price by currency, of columns such as price_eur.")

    @model_validator(mode="before")
    @classmethod
    def _with_prices(cls, given: Any) -> Any:
        row = given.as_dict() if isinstance(given, CatalogPart) else given
        return {**row, "prices": prices_of(row)} if isinstance(row, Mapping) else row


def prices_of(row: Mapping[str, Any]) -> dict[str, float]:
    """The prices in the columns of a row, by currency.

    Raises `ValueError` where a column ends in no currency.

    >>> prices_of({"name": "A", "price_eur": 40.5, "price_usd": None, "price_date": "2026-02"})
    {'eur': 40.5}
    """
    found = dict(row.get("prices") or {})
    for name, value in row.items():
        if value is None or name in _NO_PRICES or not name.startswith(PRICE):
            continue
        currency = name.removeprefix(PRICE)
        if currency not in CURRENCIES:
            known = ", ".join(PRICE + each for each in CURRENCIES)
            raise ValueError(f"{name} names no currency that is known here; known are {known}")
        found[currency] = value
    return found


def total_prices(parts: Iterable[Mapping[str, float]], per_euro: Mapping[str, float]) -> dict[str, float]:
    """The sum of the parts' prices, in each currency in which all of them are known.

    `parts`: of each part its prices by currency. `per_euro`: what one euro is in other currencies; without
    it, prices in two currencies are not added.

    >>> total_prices([{"eur": 40.0}, {"usd": 11.0}], {})
    {}
    >>> {k: round(v, 6) for k, v in total_prices([{"eur": 40.0}, {"usd": 11.0}], {"usd": 1.1}).items()}
    {'eur': 50.0, 'usd': 55.0}
    """
    rates, parts = {"eur": 1.0, **per_euro}, list(parts)
    totals = {}
    for currency in CURRENCIES:
        amounts = [amount for prices in parts if (amount := _price_in(currency, prices, rates)) is not None]
        if amounts and len(amounts) == len(parts):
            totals[currency] = sum(amounts)
    return totals


def _price_in(currency: str, prices: Mapping[str, float], rates: Mapping[str, float]) -> float | None:
    if currency in prices or currency not in rates:
        return prices.get(currency)
    known = (price / rates[own] * rates[currency] for own, price in prices.items() if own in rates)
    return next(known, None)
