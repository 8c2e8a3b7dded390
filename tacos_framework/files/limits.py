"""Limits of the size of files, and the ways in which a user changes them."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, fields
from functools import lru_cache

from tacos_framework.errors import Fault, UserError, did_you_mean

VARIABLE = "TACOS_LIMITS"
"""The environment variable that changes limits: ``TACOS_LIMITS="image_mb=1000 mesh_triangles=1e7"``."""

MB = 1_000_000
"""Bytes of a megabyte."""


@dataclass(frozen=True)
class Limits:
    """Sizes that are refused before decoding, so that no file takes more than about 1 GiB.

    Megabytes are 10^6 bytes. The defaults hold what people really have, an image of 80 megapixels in three
    channels among it; whoever has larger files and trusts them raises a limit.

    >>> limits("image_mb=1000").image_mb
    1000.0
    """

    text_mb: float = 1.0
    """Size of a YAML file, or of a table [MB]."""
    json_mb: float = 32.0
    """Size of a JSON file [MB]; in memory it may be twenty times that."""
    lines_mb: float = 400.0
    """Size of a log, or of a file with a JSON object a line [MB]."""
    image_mb: float = 256.0
    """Decoded samples of one image [MB], and size of its file."""
    array_mb: float = 400.0
    """Samples of an array, or of all arrays of one file [MB]."""
    captures_mb: float = 8000.0
    """Samples of all images of a folder of captures together, as 32-bit numbers [MB]."""
    weights_mb: float = 1000.0
    """Size of a file of weights [MB]."""
    mesh_mb: float = 128.0
    """Size of a file of triangles, with all it refers to [MB]."""
    obj_mb: float = 32.0
    """Size of an OBJ file, which is text and takes twenty times as much [MB]."""
    mesh_triangles: float = 2e6
    """Triangles of one such file, copies in the scene counted each."""

    def bytes_of(self, name: str) -> int:
        return round(getattr(self, name) * MB)

    def remedy(self, name: str, needed: float) -> str:
        """Advice where a file needs more than a limit allows, in the limit's own unit."""
        enough = math.ceil(needed * 1.01) if math.isfinite(needed) else "..."
        return f"Where you trust the file, allow more: {VARIABLE}={name}={enough} (an environment variable)."


def limits(text: str | None = None) -> Limits:
    """The limits that hold: the defaults, with what `VARIABLE` (or `text`) says of them.

    Raises `UserError` when it names a limit that there is not, or gives one no positive number.
    """
    return _limits(os.environ.get(VARIABLE, "") if text is None else text)


@lru_cache(maxsize=8)
def _limits(text: str) -> Limits:
    known = [field.name for field in fields(Limits)]
    given: dict[str, float] = {}
    faults = []
    for word in text.replace(",", " ").split():
        name, _, value = word.partition("=")
        if name not in known:
            faults.append(Fault(VARIABLE, f"there is no limit {name!r}", "", did_you_mean(name, known)))
            continue
        try:
            given[name] = float(value)
        except ValueError:
            given[name] = math.nan
        if not 0 < given[name] < math.inf:
            faults.append(Fault(VARIABLE, f"{name} is {value!r}", "a number above 0, as in image_mb=1000"))
    if faults:
        raise UserError(faults)
    return Limits(**given)
