"""Files as users have them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.worlds.imported.two_rooms import two_rooms, y_up


@pytest.fixture(scope="session")
def house(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The two rooms as GLB."""
    file = tmp_path_factory.mktemp("imported") / "house.glb"
    y_up(two_rooms()).export(file)
    return file
