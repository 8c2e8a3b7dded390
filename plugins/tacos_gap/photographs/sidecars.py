"""JSON beside photographs: settings of one picture, or of each by its name."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tacos_framework import UserError
from tacos_framework.files import read_json
from tacos_gap.photographs.tables import PicturesByName, Row, Table, row_of

SIDECAR_SUFFIX = ".json"

_OF_LIBCAMERA = frozenset({"AnalogueGain", "SensorTimestamp", "SensorBlackLevels", "FrameDuration"})
"""Controls of libcamera; where any stands beside `ExposureTime`, that counts microseconds.

Source: libcamera, "Controls and properties".
"""

_OF_EXIFTOOL = "SourceFile"
"""Key that ExifTool writes for each file; its times are in seconds."""

_WORD_ENDS = re.compile(r"(?<=[a-z])(?=[A-Z])")


def sidecars_among(others: Sequence[Path], pictures: Sequence[Path]) -> list[Table]:
    """The JSON files among files that are no pictures, each of pictures in its own folder or below.

    Such a file holds settings by names of pictures, or a list of settings that name their picture; or those
    of the one picture of its own name (``wall.json``, ``wall.png.json``), or, the only one in its folder, of
    all pictures beside it.
    """
    tables = []
    sidecars = [path for path in others if path.suffix.lower() == SIDECAR_SUFFIX]
    folders = Counter(path.parent for path in sidecars)
    for path in sidecars:
        try:
            content = read_json(path)
        except UserError:  # a file of another kind: it is passed over as such
            continue
        near = [picture for picture in pictures if picture.is_relative_to(path.parent)]
        if rows := _rows(content, path, near, of_all=folders[path.parent] == 1):
            tables.append(Table(path, rows, named=True))
    return tables


def _rows(content: Any, path: Path, pictures: Sequence[Path], *, of_all: bool) -> dict[Path, Row]:
    named = PicturesByName(pictures)
    found = {picture: row for picture, record in _records(content, named) if (row := _row(record)) != Row()}
    if found or not isinstance(content, Mapping):
        return found
    row = _row(_flat(content))
    beside = [picture for picture in pictures if picture.parent == path.parent]
    own = [picture for picture in beside if path.stem in (picture.stem, picture.name)]
    return {} if row == Row() else dict.fromkeys(own or (beside if of_all else []), row)


def _records(content: Any, named: PicturesByName) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Pictures with their settings: objects below a picture's name, and objects in which a text names one."""
    if isinstance(content, Mapping):
        named_by = [value for value in content.values() if isinstance(value, str)]
        if picture := next(filter(None, map(named.get, named_by)), None):
            yield picture, _flat(content)
            return
        for key, value in content.items():
            if isinstance(value, Mapping) and (picture := named.get(key)):
                yield picture, _flat(value)
            else:
                yield from _records(value, named)
    elif isinstance(content, list):
        for each in content:
            yield from _records(each, named)


def _flat(record: Mapping[str, Any]) -> dict[str, Any]:
    """Single values of an object and of the objects in it."""
    flat: dict[str, Any] = {}
    for key, value in record.items():
        if isinstance(value, Mapping):
            flat |= _flat(value)
        elif isinstance(value, str | int | float) and not isinstance(value, bool):
            flat[key] = value
    return flat


def _row(record: Mapping[str, Any]) -> Row:
    if (_OF_LIBCAMERA & record.keys()) and isinstance(time_us := record.get("ExposureTime"), int | float):
        gains = (record.get(key, 1.0) for key in ("AnalogueGain", "DigitalGain"))
        gain = math.prod(value for value in gains if isinstance(value, int | float))
        return Row(time_us, 1e-3, gain_db=round(20 * math.log10(gain), 2) if gain > 0 else None)
    unit = " s" if _OF_EXIFTOOL in record else ""
    headings = [_WORD_ENDS.sub(" ", key) + (unit if key == "ExposureTime" else "") for key in record]
    return row_of([str(value) for value in record.values()], headings)
