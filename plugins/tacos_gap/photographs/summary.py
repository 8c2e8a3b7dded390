"""Summary of an import, in lines to print."""

from __future__ import annotations

import shlex
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from tacos_gap.photographs.importing import Imported
from tacos_gap.report.words import captures_in_words


def summary(imported: Imported) -> Iterator[str]:
    folder = imported.path.parent
    kinds = Counter(entry["kind"] for entry in imported.entries)
    said = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
    yield f"{imported.path}: {captures_in_words(len(imported.entries))} ({said})"
    yield ""
    for entry in imported.entries:
        yield "  " + _line(entry)
    yield ""
    yield "Camera"
    for key, value in imported.camera.entry.items():
        source = imported.camera.source.get(key)
        yield (
            f"  {key} {value:g}" + (f" ({source})" if source else "")
            if _is_number(value)
            else f"  {key} {value}"
        )
    guesses = [guess.text for guess in imported.guesses]
    for title, texts in (
        ("Guessed (--ask asks, captures.yaml can be corrected)", guesses),
        ("Unsure of", imported.doubts),
    ):
        if texts:
            yield from ("", title)
        for text in texts:
            yield from textwrap.wrap(
                text, 100, initial_indent="  - ", subsequent_indent="    ", break_on_hyphens=False
            )
    yield ""
    check, diagnose = shlex.quote(str(folder)), shlex.quote(f"captures={folder}")
    yield f"Look: tacos captures view {check}"
    yield f"Next: tacos captures check {check}, then tacos-run diagnose --set {diagnose} --out out"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _line(entry: Mapping[str, Any]) -> str:
    files = [name.rpartition("/")[2] for name in entry["real"]]
    shown = files[0] if len(files) == 1 else f"{files[0]} ... {files[-1]} ({len(files)} frames)"
    settings = [f"{entry['exposure_ms']:g} ms"] if "exposure_ms" in entry else []
    settings += [f"{entry['gain_db']:g} dB"] if "gain_db" in entry else []
    settings += [entry["group"]] if "group" in entry else []
    return f"{entry['id']:<12} {shown}" + (f"  {', '.join(settings)}" if settings else "")
