"""What a world follows from, as content keys: code, versions, settings, and the files that settings name."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from functools import lru_cache
from hashlib import blake2b
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from tacos_framework.cache import content_key
from tacos_framework.settings import Settings


def code_key(cls: type[Any]) -> str | None:
    """Content key of the code of a component: its package, the core and what these plugins share; versions.

    Code of other packages counts by the versions of all distributions that are installed. None where the
    class has no file, as in a notebook: then nothing tells whether its code has changed.
    """
    root = _root_of(cls.__module__.partition(".")[0])
    if root is None:
        return None
    ours = [_root_of(name) for name in ("tacos_framework", "tacos_files", "tacos_plugins")]
    return content_key([_key_of_files(str(each)) for each in (root, *ours) if each], _machine())


def settings_key(config: Settings) -> str:
    """Content key of the settings of a component, and of all files they name."""
    plain = config.model_dump(mode="json", by_alias=True)
    files = {
        name: _key_of_files(text)
        for name, field in type(config).model_fields.items()
        if isinstance(field.json_schema_extra, dict) and field.json_schema_extra.get("path")
        if isinstance(text := getattr(config, name), str) and text and Path(text).exists()
    }
    return content_key(plain, files)


def _root_of(top: str) -> Path | None:
    """The folder of a package, or the file of a module."""
    module = sys.modules.get(top)
    file = getattr(module, "__file__", None)
    if module is None or top == "__main__" or file is None:
        return None
    return Path(file).parent if hasattr(module, "__path__") else Path(file)


def _key_of_files(root: str) -> str:
    """Content key of a file, or of all files in a folder, byte code left out."""
    stamps = tuple((str(path), path.stat().st_mtime_ns, path.stat().st_size) for path in _files(Path(root)))
    return _key_as_of(root, stamps)


@lru_cache(maxsize=32)
def _key_as_of(root: str, stamps: tuple[tuple[str, int, int], ...]) -> str:
    """The same, read once for as long as no file is written."""
    digest = blake2b(digest_size=16)
    for path, _, _ in stamps:
        content = Path(path).read_bytes()
        digest.update(f"{os.path.relpath(path, root)}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def _files(root: Path) -> Iterator[Path]:
    """All files of a folder in order, or the file itself."""
    if root.is_file():
        yield root
        return
    for folder, names, files in os.walk(root):
        names[:] = sorted(name for name in names if name != "__pycache__")
        yield from (path for name in sorted(files) if (path := Path(folder) / name).is_file())


@lru_cache(maxsize=1)
def _machine() -> str:
    """Content key of the interpreter, the processor, and the versions of all that is installed."""
    # The last bits of what numpy adds up follow from the instructions the processor offers.
    processor = Path("/proc/cpuinfo")
    about = processor.read_text().partition("\n\n")[0] if processor.exists() else platform.processor()
    kept = [line for line in about.splitlines() if line.startswith(("model name", "flags", "Features"))]
    versions = {(each.metadata["Name"] or "", each.version) for each in distributions()}
    return content_key(sys.version, platform.machine(), kept, sorted(versions))
