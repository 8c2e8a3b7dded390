"""Plain tables of comma-separated values as catalogs."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.catalog import find_catalog, read_catalog
from tests.catalog.catalog_files import TABLE, faults_of, write


def test_a_plain_table_is_a_catalog(tmp_path: Path) -> None:
    catalog = read_catalog(write(tmp_path, TABLE, "mine.csv"))
    assert catalog.name == "mine"
    assert [part.name for part in catalog.rows] == ["A", "B", "C"]
    assert catalog.rows[0].values == {
        "width_px": 1000,
        "height_px": 800,
        "pixel_um": 2.5,
        "maker": "Maker, Inc.",
        "weight": -1.5,
        "width_mm": 2.5,
        "height_mm": 2.0,
    }
    assert catalog.rows[0].provenance["width_px"] == "data sheet"
    assert catalog.rows[2].provenance["width_px"] == "mine.csv"
    assert catalog.rows[1]["pixel_um"] is None
    assert catalog.rows[1].doubts == ("Odd.",)
    assert {column.name: column.type for column in catalog.columns} == {
        "width_px": "integer",
        "height_px": "integer",
        "pixel_um": "number",
        "maker": "text",
        "weight": "number",
        "width_mm": "number",
        "height_mm": "number",
    }
    assert catalog.design_columns == ("width_mm", "height_mm", "pixel_um")
    known = [part.name for part in catalog.rows if None not in map(part.values.get, catalog.design_columns)]
    assert known == ["A", "C"]


def test_a_table_of_other_things_is_spanned_by_what_is_known_of_all(tmp_path: Path) -> None:
    table = "name,focal_length_mm,f_number,weight_g,mount\nA,3,2.0,,M12\nB,6,1.8,40,M12\n"
    assert read_catalog(write(tmp_path, table, "lenses.csv")).design_columns == (
        "focal_length_mm",
        "f_number",
    )


def test_what_may_be_negative_may_be_so_in_a_table(tmp_path: Path) -> None:
    table = "name,focal_length_mm,distortion_percent,gain_db\nA,3,-2.1,0\nB,6,0.4,6\n"
    first = read_catalog(write(tmp_path, table, "lenses.csv")).rows[0]
    assert (first["distortion_percent"], first["gain_db"]) == (-2.1, 0)


@pytest.mark.parametrize(("mark", "number"), [(";", "3,5"), (";", "3.5"), ("\t", "3.5"), (",", "3.5")])
def test_tables_of_any_spreadsheet_are_read(tmp_path: Path, mark: str, number: str) -> None:
    table = f'\ufeffname{mark}pixel_um{mark}notes\r\nA{mark}{number}{mark}"x{mark} y"\r\n'
    (row,) = read_catalog(write(tmp_path, table, "sensors.csv")).rows
    assert row["pixel_um"] == 3.5
    assert row.notes == (f"x{mark} y",)


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("", [("1", "the first line names no column 'name', but nothing")]),
        ("part,width_px\nA,3\n", [("1", "the first line names no column 'name', but part, width_px")]),
        ("name,width_px\n", [("1", "the catalog is empty")]),
        ("name,width_px,width_px\nA,1,2\n", [("1", "column 'width_px' stands here more than once")]),
        ("name,width_px\nA,1,2\n", [("2", "this line has 3 values")]),
        ("name,width_px\n,1\n", [("2", "this part has no name")]),
        (
            'name,width_px\nA,"1',
            [("2", "this is no table of comma-separated values: unexpected end of data")],
        ),
        (
            'name,width_px,note\nA,x,"two\nlines"\nB,nan,\nb,-1,\n',
            [
                ("5", None),
                ("3", "width_px of A is 'x'"),
                ("4", "width_px of B is 'nan'"),
                ("5", "width_px of b is -1, which is not above 0"),
            ],
        ),
    ],
)
def test_tables_that_are_no_catalog(tmp_path: Path, text: str, faults: list[tuple[str, str | None]]) -> None:
    found = faults_of(write(tmp_path, text, "mine.csv"))
    assert [where for where, _ in found] == [where for where, _ in faults]
    assert all(what in (None, said) for (_, what), (_, said) in zip(faults, found, strict=True))


@pytest.mark.parametrize(
    ("line", "doubt"),
    [
        ("slip,1280,960,0.00375", "pixel_um is 0.00375; parts have 0.4 to 60. Is it in another unit?"),
        ("slip,1280,960,3750", "pixel_um is 3750; parts have 0.4 to 60. Is it in another unit?"),
        ("slip,1280,4,3.75", "height_px is 4; parts have 8 to 40000. Is it in another unit?"),
    ],
)
def test_numbers_that_look_like_a_slip_of_the_unit_are_doubted(tmp_path: Path, line: str, doubt: str) -> None:
    path = write(tmp_path, f"name,width_px,height_px,pixel_um\nfine,1280,960,3.75\n{line}\n", "units.csv")
    fine, slip = find_catalog(path).rows
    assert fine.doubts == ()
    assert doubt in slip.doubts


@pytest.mark.parametrize(
    ("heading", "name"),
    [
        ("name,width_px,height_px,pixel_um", "mine.tsv"),
        ("NAME,WIDTH_PX,HEIGHT_PX,PIXEL_UM", "mine.CSV"),
        ("Name,Width [px],Height [px],Pixel size [\u00b5m]", "mine.csv"),
        ("name,width (px),height (px),pixel (um)", "mine.csv"),
        ("name,width_px,height_px,pixel_um,,", "mine.csv"),
    ],
)
def test_headings_may_have_capitals_units_in_brackets_and_empty_columns_behind(
    tmp_path: Path, heading: str, name: str
) -> None:
    mark = "\t" if name.endswith("tsv") else ","
    table = f"{heading}\nA,1000,800,2.5{',,' * heading.endswith(',')}\n".replace(",", mark)
    (row,) = read_catalog(write(tmp_path, table, name)).rows
    assert (row["width_px"], row["pixel_um"], row["width_mm"]) == (1000, 2.5, 2.5)
    assert len(row.values) == 5
