"""Tables as spreadsheets and programs of many countries write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.files import read_csv


@pytest.mark.parametrize(
    "text",
    [
        "a,b\n1.5,2\n",
        "a;b\n1,5;2\n",
        "a\tb\n1.5\t2\n",
        "# by hand; in air, at 20 deg\n\n# (SK16, F2)\na,b\n1.5,2\n",
        "#made by; a logger\na;b\n1,5;2\n",
    ],
)
def test_columns_are_parted_by_what_the_first_line_without_a_remark_has(tmp_path: Path, text: str) -> None:
    (tmp_path / "table.csv").write_text(text)
    lines = [cells for _, cells in read_csv(tmp_path / "table.csv") if cells and cells[0][:1] != "#"]
    assert lines == [["a", "b"], ["1.5", "2"]]


def test_a_note_with_a_semicolon_parts_no_columns(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("name,bright; or not\nx,1; 2\n")
    assert [cells for _, cells in read_csv(tmp_path / "table.csv")] == [
        ["name", "bright; or not"],
        ["x", "1; 2"],
    ]


def test_a_head_that_is_a_remark_leaves_the_numbers_to_tell(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("#t;x;y\n1,5;2;3,25\n")
    assert read_csv(tmp_path / "table.csv")[1][1] == ["1.5", "2", "3.25"]
