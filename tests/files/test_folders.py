"""Folders that commands write into: made, or refused with what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.errors import UserError
from tacos_framework.files import made_folder


def test_folders_are_made_with_those_they_lie_in(tmp_path: Path) -> None:
    assert made_folder(tmp_path / "a" / "b").is_dir()
    assert made_folder(tmp_path / "a").is_dir()  # there already


@pytest.mark.parametrize("below", ["", "below", "far/below"])
def test_a_file_in_the_way_is_named(tmp_path: Path, below: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match=f"{tmp_path / 'file'} is a file"):
        made_folder(tmp_path / "file" / below)


def test_what_the_system_refuses_is_said() -> None:
    with pytest.raises(UserError, match="cannot be made"):
        made_folder(Path("/proc/nothing/here"))
