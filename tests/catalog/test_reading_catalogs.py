"""Catalogs of users: what they may hold, and what is said about what they may not."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.catalog import read_catalog
from tacos_framework.catalog.checks import unit_of
from tacos_framework.errors import UserError
from tests.catalog.catalog_files import FIRST, HEAD, faults_of, read, write


def test_sources_may_be_named_once_and_every_value_graded(tmp_path: Path) -> None:
    head = HEAD.replace(
        "source: me\n",
        "source: me\ngrade: hobby list\n"
        "sources: {sheet: {title: Data sheet 2.1, grade: data sheet}, shop: {title: A shop}}\n",
    )
    path = write(
        tmp_path,
        head + "  A: {width_px: 10, height_px: {value: 8, source: sheet}, maker: {value: M, source: shop}}\n"
        "  B: {width_px: 10, source: sheet, pixel_um: {value: 2, source: sheet, grade: derived}}\n"
        "  C: {width_px: 10, source: a friend}\n",
    )
    a, b, c = read_catalog(path).rows
    assert a.provenance["height_px"] == "Data sheet 2.1"
    assert a.grades == {"width_px": "hobby list", "height_px": "data sheet"}
    assert b.grades == {"width_px": "data sheet", "pixel_um": "derived"}
    assert (c.provenance["width_px"], c.grades) == ("a friend", {})


def test_a_grade_is_one_of_those_known(tmp_path: Path) -> None:
    path = write(tmp_path, HEAD + "  A: {width_px: {value: 10, source: me, grade: sure}}\n")
    ((_, what),) = faults_of(path)
    assert "sure" in what
    table = write(tmp_path, "name,pixel_um,grade\nA,2,sure\nB,3,data sheet\n", "table.csv")
    assert "sure" in faults_of(table)[0][1]
    good = write(tmp_path, "name,pixel_um,grade\nA,2,\nB,3,data sheet\n", "good.csv")
    assert [part.grades for part in read_catalog(good).rows] == [{}, {"pixel_um": "data sheet"}]


def test_values_provenance_doubts_and_notes(tmp_path: Path) -> None:
    catalog = read(
        tmp_path,
        "  A: {width_px: 1000, pixel_um: {value: 2.5, source: data sheet}, maker: unknown, offset_mm: -1}\n"
        "  B: {width_px: 500, height_px: 400, pixel_um: 3, source: a friend,\n"
        "      doubts: [Odd.], notes: [New.]}\n",
    )
    a, b = catalog.rows
    assert a.values == {
        "width_px": 1000,
        "height_px": None,
        "pixel_um": 2.5,
        "width_mm": 2.5,
        "height_mm": None,
        "offset_mm": -1.0,
        "maker": None,
    }
    assert a.provenance == {
        "width_px": "me",
        "pixel_um": "data sheet",
        "width_mm": "width_px x pixel_um",
        "offset_mm": "me",
    }
    assert b.provenance["pixel_um"] == "a friend"
    assert (b.doubts, b.notes) == (("Odd.",), ("New.",))
    assert [(column.name, column.unit) for column in catalog.columns][:3] == [
        ("width_px", "px"),
        ("height_px", "px"),
        ("pixel_um", "um"),
    ]
    assert catalog.design_columns == ("width_mm", "height_mm", "pixel_um")
    assert catalog.part("B") is b
    with pytest.raises(ValueError, match=r"catalog sensors has no part 'C'"):
        catalog.part("C")


def test_sizes_that_follow_from_pixels_and_pitch_need_no_column(tmp_path: Path) -> None:
    text = HEAD.replace("  width_mm:  {help: Width.}\n", "").replace("  height_mm: {help: Height.}\n", "")
    text = "design_columns: [width_mm, pixel_um]\n" + text + "  A: {width_px: 1000, pixel_um: 2.5}\n"
    catalog = read_catalog(write(tmp_path, text))
    assert catalog.part("A")["width_mm"] == 2.5
    assert catalog.design_columns == ("width_mm", "pixel_um")


def test_a_size_that_contradicts_its_pixels_is_doubted(tmp_path: Path) -> None:
    catalog = read(
        tmp_path,
        "  A: {width_px: 1000, pixel_um: 2.5, width_mm: 2.52}\n"
        "  B: {width_px: 1000, pixel_um: 2.5, width_mm: 3}\n",
    )
    assert [part.doubts for part in catalog.rows] == [
        (),
        ("width_mm is 3, but 1000 pixels of 2.5 um are 2.5 mm.",),
    ]


def test_parts_alike_under_two_names_are_doubted(tmp_path: Path) -> None:
    catalog = read(tmp_path, "  A: {width_px: 1000}\n  B: {width_px: 1000}\n")
    assert catalog.part("B").doubts == ("All values are those of A.",)


def test_all_faults_of_a_catalog_come_at_once_with_their_places(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        HEAD
        + "  A: {width_px: 1000, widht_px: 3}\n"
        + "  B: {width_px: 10.5, pixel_um: 2.5 um}\n"
        + "  C: {height_px: -3, pixel_um: 0}\n"
        + "  a: {width_px: many}\n"
        + "  E: 7\n"
        + "  F:\n"
        + "    width_px: {value: 3, sauce: x}\n"
        + "    maker: 7\n",
    )
    assert faults_of(path) == [
        (f"{FIRST + 4}:3", "part E has no values"),
        (f"{FIRST + 6}:5", "'source' is missing"),
        (f"{FIRST + 6}:26", "unknown key 'sauce'"),
        (f"{FIRST + 3}:3", f"part 'a' stands here again, first at {path}:{FIRST}:3"),
        (f"{FIRST}:23", "A has a value for 'widht_px', which is no column"),
        (f"{FIRST + 1}:7", "width_px of B is 10.5, which is not whole"),
        (f"{FIRST + 1}:23", "pixel_um of B is '2.5 um'"),
        (f"{FIRST + 2}:3", "C has no width_px"),
        (f"{FIRST + 2}:7", "height_px of C is -3, which is not above 0"),
        (f"{FIRST + 2}:22", "pixel_um of C is 0, which is not above 0"),
        (f"{FIRST + 3}:7", "width_px of a is 'many'"),
        (f"{FIRST + 7}:5", "maker of F is 7"),
    ]


def test_a_value_with_its_unit_says_which_unit_the_column_has(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="Write the number alone; the column is in um"):
        read(tmp_path, "  A: {width_px: 100, pixel_um: 1.4 nm}\n")


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("[1, 2]\n", [("1:1", "this is no catalog of parts")]),
        ("", [("1:1", "this is no catalog of parts")]),
        (HEAD, [(f"{FIRST - 1}:1", "this is no catalog of parts")]),
        (HEAD.replace("parts:", "parts: {}"), [(f"{FIRST - 1}:1", "the catalog is empty")]),
        (
            HEAD.replace("pixel_um:  {", "pixel_um:  {unit: mm, ") + "  A: {width_px: 1}\n",
            [("6:15", "the unit of pixel_um is mm")],
        ),
        (
            "design_columns: [pixel_mm, maker]\n" + HEAD + "  A: {width_px: 1}\n",
            [
                ("1:18", "there is no column of numbers 'pixel_mm'"),
                ("1:28", "there is no column of numbers 'maker'"),
            ],
        ),
        (HEAD + "  A: {width_px: 1}\n  A: {width_px: 2}\n", [(f"{FIRST + 1}:3", None)]),
        (HEAD + "  A: {width_px: .nan}\n", [(f"{FIRST}:17", None)]),
        (
            HEAD.replace("title", "titel") + "  A: {width_px: 1}\n",
            [("1:1", None), ("1:1", "unknown key 'titel'")],
        ),
    ],
)
def test_files_that_are_no_catalog(tmp_path: Path, text: str, faults: list[tuple[str, str | None]]) -> None:
    found = faults_of(write(tmp_path, text))
    assert [where for where, _ in found] == [where for where, _ in faults]
    assert all(what in (None, said) for (_, what), (_, said) in zip(faults, found, strict=True))


@pytest.mark.parametrize(
    ("name", "unit"),
    [("pixel_um", "um"), ("dark_current_e_s", "e-/s"), ("read_noise_e", "e-"), ("maker", None), ("um", None)],
)
def test_the_end_of_a_name_is_its_unit(name: str, unit: str | None) -> None:
    assert unit_of(name) == unit
