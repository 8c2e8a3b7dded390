"""Dates with a time of day, as stamps of recordings have them."""

from __future__ import annotations

import re
from datetime import datetime

_DATE = re.compile(
    r"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d)(?:[.,](\d+))?\s?(Z|[+-]\d\d:?\d\d)?", re.ASCII | re.IGNORECASE
)
"""By ISO 8601; also with a space before the time of day, and with nanoseconds."""


def date_ns(text: str) -> int | None:
    """Time since 1970 of a date with a time of day, in UTC where it names no zone [ns]; None for other text.

    >>> date_ns("1970-01-01 00:00:01.000000002"), date_ns("1970-01-01T02:00:00+01:00"), date_ns("1.5")
    (1000000002, 3600000000000, None)
    """
    if (found := _DATE.fullmatch(text.strip())) is None:
        return None
    try:
        whole_s = datetime.fromisoformat(found[1] + (found[3] or "Z").upper()).timestamp()
    except ValueError:  # the 32nd, the 13th month
        return None
    return int(whole_s) * 10**9 + int((found[2] or "").ljust(9, "0")[:9])
