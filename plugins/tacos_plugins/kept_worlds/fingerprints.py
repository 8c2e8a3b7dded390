"""Inputs of a world as content keys: code, versions, settings, and the files that settings name."""

from __future__ import annotations

import platform
import sys
from functools import lru_cache
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from tacos_framework import Settings, content_key, paths_in
from tacos_framework.files import checksums_below


def code_key(cls: type[Any]) -> str | None:
    """Content key of the code of a component: its package, the core and what these plugins share; versions.

    Code of other packages counts by the versions of all distributions that are installed. None where the
    class has no file, as in a notebook: then nothing tells whether its code has changed.
    """
    root = _root_of(cls.__module__.partition(".")[0])
    if root is None:
        return None
    ours = [_root_of(name) for name in ("tacos_framework", "tacos_files", "tacos_plugins")]
    return content_key([checksums_below(each) for each in (root, *ours) if each], _machine())


def settings_key(config: Settings) -> str:
    """Content key of the settings of a component, and of all files they name."""
    plain = config.model_dump(mode="json", by_alias=True)
    files = {name: checksums_below(Path(text)) for name, text in paths_in(config) if Path(text).exists()}
    return content_key(plain, files)


def _root_of(top: str) -> Path | None:
    """The folder of a package, or the file of a module."""
    module = sys.modules.get(top)
    file = getattr(module, "__file__", None)
    if module is None or top == "__main__" or file is None:
        return None
    return Path(file).parent if hasattr(module, "__path__") else Path(file)


@lru_cache(maxsize=1)
def _machine() -> str:
    """Content key of the interpreter, the processor, and the versions of all that is installed."""
    # The last bits of what numpy adds up follow from the instructions the processor offers.
    processor = Path("/proc/cpuinfo")
    about = processor.read_text().partition("\n\n")[0] if processor.exists() else platform.processor()
    kept = [line for line in about.splitlines() if line.startswith(("model name", "flags", "Features"))]
    versions = {(each.metadata["Name"] or "", each.version) for each in distributions()}
    return content_key(sys.version, platform.machine(), kept, sorted(versions))
