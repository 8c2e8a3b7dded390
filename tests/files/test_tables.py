"""Tables as spreadsheets and programs of many countries write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework import UserError
from tacos_framework.files import read_csv, read_rows, read_text


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


@pytest.mark.parametrize("coding", ["utf-8-sig", "utf-16", "cp1252"])
def test_tables_in_any_coding_of_spreadsheets_are_read_and_a_guess_is_said(
    tmp_path: Path, coding: str, caplog: pytest.LogCaptureFixture
) -> None:
    table = tmp_path / "table.csv"
    table.write_bytes("Maker;Size \u00b5m\nK\u00f6ln \u2013 1;1,5\n".encode(coding))
    assert read_csv(table) == [(1, ["Maker", "Size \u00b5m"]), (2, ["K\u00f6ln \u2013 1", "1.5"])]
    assert ("read as Windows-1252" in caplog.text) == (coding == "cp1252")


def test_text_that_is_no_table_is_not_guessed_nor_are_bytes_that_are_no_text(tmp_path: Path) -> None:
    file = tmp_path / "file.csv"
    file.write_bytes("K\u00f6ln".encode("cp1252"))
    with pytest.raises(UserError, match="byte 0xf6 is not UTF-8"):
        read_text(file)
    for content in (b"a,b\n\xff\0,1\n", b"a,b\n\x81,1\n"):
        file.write_bytes(content)
        with pytest.raises(UserError, match=":2: byte 0x"):
            read_csv(file)


@pytest.mark.parametrize(
    "text",
    ["sep=;\na;b\n1,5;2\n", "sep=,\r\na,b\r\n1.5,2\r\n", '"sep=|"\na|b\n1.5|2\n', "SEP=\t\na\tb\n1.5\t2\n"],
)
def test_the_line_by_which_excel_parts_columns_is_obeyed_and_left_out(tmp_path: Path, text: str) -> None:
    (tmp_path / "table.csv").write_text(text, newline="")
    assert read_csv(tmp_path / "table.csv") == [(2, ["a", "b"]), (3, ["1.5", "2"])]


def test_rows_have_headings_in_small_letters_and_no_empty_lines(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("Name,SIZE\n\nA,1\n,\nB\n")
    headings, rows = read_rows(tmp_path / "table.csv")
    assert headings == ["name", "size"]
    assert rows == [(3, {"name": "A", "size": "1"}), (5, {"name": "B"})]
