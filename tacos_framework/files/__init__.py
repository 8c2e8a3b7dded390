"""Files from outside, read safely: the one door through which bytes of others come in.

Nothing that stands in a file is trusted: it may be a pipe, a link out of its folder, cut short, or claim
sizes that no memory holds. Every reader here opens regular files alone, knows from the header what decoding
will take, refuses what is above a stated limit, and says what is wrong in a `tacos_framework.errors.Fault`.

``regular``  bytes of a regular file, not too many, not from elsewhere
``limits``   how much a file may take, and how a user changes that
``text``     text; JSON; tables of comma-separated values
``folders``  folders that commands write into
``trees``    checksums of files and folders, to tell whether they have changed

On top of them `tacos_framework.settings.yaml_reader` reads YAML, and `tacos_files` images and arrays.
"""

from __future__ import annotations

from tacos_framework.files.folders import made_folder
from tacos_framework.files.limits import MB, Limits, limits
from tacos_framework.files.regular import named_file, read_bytes, too_large
from tacos_framework.files.text import (
    CSV_SUFFIXES,
    decoded,
    finite_number,
    parse_json,
    read_csv,
    read_json,
    read_lines,
    read_rows,
    read_text,
)
from tacos_framework.files.trees import checksums_below

__all__ = [
    "CSV_SUFFIXES",
    "MB",
    "Limits",
    "checksums_below",
    "decoded",
    "finite_number",
    "limits",
    "made_folder",
    "named_file",
    "parse_json",
    "read_bytes",
    "read_csv",
    "read_json",
    "read_lines",
    "read_rows",
    "read_text",
    "too_large",
]
