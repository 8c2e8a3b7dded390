"""Catalogs of users: what they may hold, and what is said about what they may not."""

from __future__ import annotations

from pathlib import Path

import pytest

from tacos_framework.catalog import Catalog, find_catalog, load_cameras, read_catalog
from tacos_framework.catalog.checks import unit_of
from tacos_framework.errors import UserError
from tacos_framework.packaged_resources import shipped_folder
from tacos_plugins.sensors.calibration import load_calibration

HEAD = """\
title: Two sensors
source: me
columns:
  width_px:  {type: integer, required: true, help: Width.}
  height_px: {type: integer, help: Height.}
  pixel_um:  {help: Pitch.}
  width_mm:  {help: Width.}
  height_mm: {help: Height.}
  offset_mm: {positive: false, help: Offset.}
  maker:     {type: text, help: Maker.}
parts:
"""
FIRST = HEAD.count("\n") + 1


def write(folder: Path, text: str, name: str = "sensors.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def read(folder: Path, parts: str) -> Catalog:
    return read_catalog(write(folder, HEAD + parts))


def faults_of(path: Path) -> list[tuple[str, str]]:
    with pytest.raises(UserError) as caught:
        read_catalog(path)
    return [(fault.where.removeprefix(f"{path}:"), fault.what) for fault in caught.value.faults]


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


TABLE = """\
name,width_px,height_px,pixel_um,maker,weight,source,doubts
A,1000,800,2.5,"Maker, Inc.",-1.5,data sheet,
B,500,400,unknown,,,,Odd.

C,640,480,3e0,X,2,,
"""


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
    assert [part.name for part in catalog.rows_knowing(catalog.design_columns)] == ["A", "C"]


def test_a_table_of_other_things_is_spanned_by_what_is_known_of_all(tmp_path: Path) -> None:
    table = "name,focal_length_mm,f_number,weight_g,mount\nA,3,2.0,,M12\nB,6,1.8,40,M12\n"
    assert read_catalog(write(tmp_path, table, "lenses.csv")).design_columns == (
        "focal_length_mm",
        "f_number",
    )


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
    ("name", "unit"),
    [("pixel_um", "um"), ("dark_current_e_s", "e-/s"), ("read_noise_e", "e-"), ("maker", None), ("um", None)],
)
def test_the_end_of_a_name_is_its_unit(name: str, unit: str | None) -> None:
    assert unit_of(name) == unit


def test_paths_of_a_recipe_start_beside_it_and_may_lead_anywhere(tmp_path: Path) -> None:
    folder = tmp_path / "recipes"
    (folder / "parts").mkdir(parents=True)
    write(tmp_path, TABLE, "outside.csv")
    write(folder / "parts", TABLE, "mine.csv")
    (folder / "link.csv").symlink_to(tmp_path / "outside.csv")
    for name in ("parts/mine.csv", "../outside.csv", str(tmp_path / "outside.csv"), "link.csv"):
        assert len(find_catalog(name, folder).rows) == 3
    assert len(find_catalog(tmp_path / "outside.csv").rows) == 3


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("image_sensor", r"no catalog of this name is shipped[\s\S]*Did you mean 'image_sensors'"),
        ("mine", r"Write 'mine.csv' to use the file beside the recipe"),
        ("missing.yaml", "there is no such catalog"),
        (".", "there is no such catalog"),
        ("", "there is no such catalog"),
        ("a\0.yaml", "NUL"),
        ("cameras", "this is no catalog of parts"),
    ],
)
def test_catalogs_that_are_not_there(tmp_path: Path, name: str, message: str) -> None:
    write(tmp_path, TABLE, "mine.csv")
    with pytest.raises(UserError, match=message):
        find_catalog(name, tmp_path)


def test_shipped_files_are_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(find_catalog("image_sensors").rows) == 43
    assert shipped_folder("recipes").is_absolute()
    assert load_calibration("flea3_imx172").bit_depth == 8


def test_all_unknown_cameras_are_told() -> None:
    with pytest.raises(UserError) as caught:
        load_cameras(["flea", "zed_2i", "oak", "zed_2i"])
    assert [(fault.where, fault.remedy) for fault in caught.value.faults] == [
        ("flea", "Did you mean 'flea3'?"),
        ("oak", "Did you mean 'oak_d_pro_wide'?"),
        ("zed_2i", "Remove one."),
    ]


def test_cameras_of_users(tmp_path: Path) -> None:
    camera = "{title: T, maker: M, rig: rig.stereo, fixes: {baseline_m: 1}, sources: [me]}"
    write(tmp_path, f"cameras:\n  mine: {camera}\n", "cams.yaml")
    [found] = load_cameras(["mine"], "cams.yaml", tmp_path)
    assert (found.name, found.rig, found.fixes) == ("mine", "rig.stereo", {"baseline_m": 1})
    write(
        tmp_path,
        "cameras:\n  mine: {title: T, maker: M, rig: stereo, fixes: {}, source: [me]}\n",
        "cams.yaml",
    )
    with pytest.raises(UserError) as caught:
        load_cameras(["mine"], "cams.yaml", tmp_path)
    said = str(caught.value)
    assert all(text in said for text in ("cams.yaml:2:", "rig", "fixes", "'cameras.mine.sources' is missing"))


def test_calibrations_of_users(tmp_path: Path) -> None:
    text = (shipped_folder("catalogs") / "noise" / "flea3_imx172.yaml").read_text()
    write(tmp_path, text.replace("gain_db: 15", "gain_db: 3"), "mine.yaml")
    assert load_calibration("mine.yaml", tmp_path).gain_db == 3
    write(tmp_path, text.replace("[1.82, 0.91, 3.2]", "[1.82, 0.91]"), "mine.yaml")
    with pytest.raises(
        UserError, match="photon_dn has 3 channels and thermal_dn2 2; 3 of each, or 1 of each"
    ):
        load_calibration("mine.yaml", tmp_path)
    write(tmp_path, text.replace("0.91", "-0.91").replace("pixel_um: 1.55", "pixel_um: 0"), "mine.yaml")
    with pytest.raises(UserError) as caught:
        load_calibration("mine.yaml", tmp_path)
    assert len(caught.value.faults) == 2


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
