"""Fake distributions."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable

import pytest

Install = Callable[..., None]


@pytest.fixture
def distribution(tmp_path, monkeypatch) -> Install:
    """Installs a fake distribution that offers a plugin module of the given source."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def install(name: str, source: str, *, entry_point: str = "", metadata: bool = True) -> None:
        module = name.replace("-", "_")
        (tmp_path / f"{module}.py").write_text(textwrap.dedent(source))
        info = tmp_path / f"{module}-1.0.dist-info"
        info.mkdir()
        if metadata:
            (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        line = entry_point or f"{module} = {module}"
        (info / "entry_points.txt").write_text(f"[tacos]\n{line}\n")
        monkeypatch.delitem(sys.modules, module, raising=False)

    return install
