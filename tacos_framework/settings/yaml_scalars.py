"""Unquoted text of YAML as values: the core schema of YAML 1.2, without NaN and infinities.

Source: YAML 1.2.2 core schema: https://yaml.org/spec/1.2.2/#103-core-schema
"""

from __future__ import annotations

import re
from math import isfinite
from typing import Any

LONGEST_NUMBER = 40
"""Characters of a number at most."""

_NULL = frozenset({"", "~", "null", "Null", "NULL"})
_BOOLEAN = {word: word.lower() == "true" for word in ("true", "True", "TRUE", "false", "False", "FALSE")}
_DECIMAL = re.compile(r"[-+]?[0-9]+")
_PREFIXED = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.?(inf|infinity|nan)", re.IGNORECASE)


def reads_as_text(text: str) -> bool:
    """True if unquoted text is read as text, not as a number, a truth value or nothing, and not refused."""
    try:
        return isinstance(plain_scalar(text), str)
    except ValueError:
        return False


def plain_scalar(text: str) -> Any:
    """The value of unquoted text by the YAML 1.2 core schema; ValueError for what is no usable number."""
    if text in _NULL:
        return None
    if text in _BOOLEAN:
        return _BOOLEAN[text]
    if _NOT_FINITE.fullmatch(text):
        raise ValueError(f"{text} is not a number that can be used")
    if not _FLOAT.fullmatch(text) and not _PREFIXED.fullmatch(text):
        return text
    if len(text) > LONGEST_NUMBER:
        raise ValueError(f"a number of {len(text)} characters is too long")
    if _DECIMAL.fullmatch(text):
        return int(text)
    if _PREFIXED.fullmatch(text):
        return int(text, 0)
    number = float(text)
    if not isfinite(number):
        raise ValueError(f"{text} is too large for a number")
    return number
