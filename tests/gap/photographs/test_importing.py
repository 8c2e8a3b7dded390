"""Photographs sorted into captures by what they say and show."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from tacos_framework.cli import tacos_main
from tacos_framework.errors import UserError
from tacos_gap.captures import read_captures
from tacos_gap.photographs.facts import read_facts
from tacos_gap.photographs.given import Given
from tacos_gap.photographs.importing import import_photographs
from tests.gap.captures.targets.test_chart import photographed
from tests.gap.captures.targets.test_slanted_edge import edge
from tests.gap.captures.targets.test_two_tone import page
from tests.gap.captures.targets.test_two_tone import photographed as print_photographed

DATA = Path(__file__).parents[4] / "shared" / "data" / "real"
SHAPE = (240, 320)
RNG = np.random.default_rng(5)


def save(path: Path, image: np.ndarray, exposure_s=0.01, iso=100) -> None:
    """A PNG of noisy values, with EXIF as cameras write it."""
    noisy = image + RNG.normal(0, 1.2, image.shape)
    tags = Image.Exif()
    tags[0x0110] = "Test 1"
    own = tags.get_ifd(0x8769)
    own |= {0x829A: exposure_s, 0x8827: iso, 0x920A: 6.0, 0x829D: 4.0, 0xA20E: 5080.0, 0xA210: 2}
    Image.fromarray(np.clip(np.rint(noisy), 0, 255).astype(np.uint8)).save(path, exif=tags)


def board() -> np.ndarray:
    squares = np.kron(np.indices((6, 8)).sum(axis=0) % 2, np.ones((26, 26)))
    return 30 + 170 * np.pad(squares, ((42, 42), (56, 56)), constant_values=1)


@pytest.fixture
def photos(tmp_path):
    """Cap at two times, a wall twice, a bracket, an edge, a board, a chart."""
    folder = tmp_path / "photos"
    folder.mkdir()
    rgb = np.ones(3)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    fall_off = 1 - 0.3 * ((x - 160) ** 2 + (y - 120) ** 2) / (160**2 + 120**2)
    for k in range(2):
        save(folder / f"a{k}.png", np.full((*SHAPE, 3), 12.0))
        save(folder / f"b{k}.png", np.full((*SHAPE, 3), 12.3), exposure_s=1.0)
        save(folder / f"c{k}.png", 12 + (150 * fall_off)[..., None] * rgb)
    view = cv2.GaussianBlur(RNG.uniform(0, 1, (12, 16, 3)).repeat(20, 0).repeat(20, 1), (0, 0), 2.0) ** 2
    for k, time_s in enumerate((0.02, 0.04)):
        save(folder / f"d{k}.png", 12 + 60 * view * time_s / 0.01, exposure_s=time_s)
    save(folder / "e.png", edge(5, 1.0, SHAPE)[..., None] * rgb)
    save(folder / "f.png", board()[..., None] * rgb)
    save(folder / "g.png", 12 + 230 * photographed(8, size=(240, 320))[0] ** 0.45)
    return folder


def test_every_kind_is_told_and_the_folder_can_be_read(photos, tmp_path):
    found = import_photographs([photos], tmp_path / "out")
    kinds = [(entry["kind"], len(entry["real"])) for entry in found.entries]
    assert kinds == [
        ("dark", 2),
        ("dark", 2),
        ("flat", 2),
        ("bracket", 1),
        ("bracket", 1),
        ("edge", 1),
        ("board", 1),
        ("chart", 1),
    ]
    assert found.camera.entry["black_level_dn"] == pytest.approx(12, abs=0.5)
    assert found.camera.entry["pixel_um"] == 5.0
    assert found.camera.entry["focal_length_mm"] == 6.0
    assert found.entries[6]["board"]["inner_corners"] == [7, 5]
    folder = read_captures(tmp_path / "out")
    assert len(folder.captures) == len(found.entries)
    assert all(each.expected_dn is not None for each in folder.captures if each.kind != "board")


def test_the_commands_import_guide_and_say_their_doubts(photos, tmp_path, capsys):
    out = tmp_path / "out"
    assert tacos_main(["captures", "import", str(photos), "--out", str(out), "--board", "7x5"]) == 0
    printed = capsys.readouterr().out
    assert "8 captures (2 dark, 1 flat, 2 bracket, 1 edge, 1 board, 1 chart)" in printed
    assert "The squares of the board are taken to be 25 mm" in printed
    assert "# EXIF" in (out / "captures.yaml").read_text()
    assert tacos_main(["captures", "import", str(photos), "--out", str(out)]) == 2
    assert "is not empty" in capsys.readouterr().err


def test_pictures_of_a_wall_at_several_times_are_a_bracket_and_a_wall(tmp_path):
    for k, time_s in enumerate((0.01, 0.02, 0.04)):
        save(tmp_path / f"wall{k}.png", np.full(SHAPE, 10 + 40 * time_s / 0.01), exposure_s=time_s)
    entries = import_photographs([tmp_path], tmp_path / "out").entries
    assert [entry["kind"] for entry in entries] == ["flat", "bracket", "bracket", "bracket"]


@pytest.mark.parametrize(
    ("name", "exposure_ms"),
    [
        ("dark_10ms.png", 10),
        ("d1_dark_250us_x.png", 0.25),
        ("wall 2s.png", 2000),
        ("items.png", None),
        ("dark 2,5ms.png", 2.5),
        ("a_40µs.png", 0.04),
        ("3 sec.png", 3000),
    ],
)
def test_exposure_times_in_names_are_read(tmp_path, name, exposure_ms):
    Image.fromarray(np.zeros((4, 4), np.uint8)).save(tmp_path / name)
    facts = read_facts(tmp_path / name)
    assert facts.exposure_ms == exposure_ms
    assert bool(facts.time_from) == (exposure_ms is not None)


def test_what_is_no_photograph_is_refused_in_a_sentence(tmp_path):
    with pytest.raises(UserError, match="is neither a file nor a folder"):
        import_photographs([tmp_path / "none"], tmp_path / "out")
    (tmp_path / "photos").mkdir()
    with pytest.raises(UserError, match="holds no pictures"):
        import_photographs([tmp_path / "photos"], tmp_path / "out")
    (tmp_path / "photos/a.jpg").write_bytes(b"no picture")
    with pytest.raises(UserError, match=r"a\.jpg is no image that can be read"):
        import_photographs([tmp_path / "photos"], tmp_path / "out")
    save(tmp_path / "photos/a.jpg", np.full((*SHAPE, 3), 90.0) * [1, 0.9, 0.8])
    with pytest.raises(UserError, match="pictures are in colour"):
        import_photographs([tmp_path / "photos"], tmp_path / "out", Given(cfa="RGGB"))


def test_pictures_that_say_when_stand_in_the_order_they_were_taken(tmp_path):
    (tmp_path / "photos").mkdir()
    for name, level, taken in (("a", 150.0, "00:07"), ("b", 12.0, "00:30")):
        path = tmp_path / "photos" / f"{name}.png"
        save(path, np.full((*SHAPE, 3), level))
        with Image.open(path) as image:
            tags = image.getexif()
            tags.get_ifd(0x8769)[0x9003] = f"2026:05:01 10:{taken}"
            image.save(path, exif=tags)
    entries = import_photographs([tmp_path / "photos"], tmp_path / "out").entries
    assert [(e["kind"], e["taken_s"]) for e in entries] == [("flat", 0.0), ("dark", 23.0)]
    assert [c.taken_s for c in read_captures(tmp_path / "out").captures] == [0.0, 23.0]


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")
def test_a_real_bracket_is_imported_from_its_exif(tmp_path):
    found = import_photographs([DATA / "bracket_5d2"], tmp_path / "out")
    assert [(e["kind"], e["exposure_ms"], e["group"]) for e in found.entries] == [
        ("bracket", time_ms, "view_1") for time_ms in (125.0, 1000.0, 8000.0)
    ]
    assert any("lossy" in doubt for doubt in found.doubts)
    assert any("Photos 1.0.1" in doubt for doubt in found.doubts)


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")
def test_real_boards_are_counted_and_tell_the_focal_length(tmp_path):
    found = import_photographs([DATA / "boards_hx5v"], tmp_path / "out")
    assert {tuple(entry["board"]["inner_corners"]) for entry in found.entries} == {(6, 4)}
    focal_px = found.camera.entry["focal_length_mm"] / found.camera.entry["pixel_um"] * 1e3
    assert focal_px == pytest.approx(693, rel=0.03)


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the real captures are not at {DATA}")
def test_frames_of_a_machine_vision_camera_are_sorted_by_their_names(tmp_path):
    entries = import_photographs([DATA / "flea3_raw"], tmp_path / "out", Given(cfa="GRBG")).entries
    darks = {entry["exposure_ms"]: len(entry["real"]) for entry in entries if entry["kind"] == "dark"}
    assert darks == dict.fromkeys((25.0, 50.0, 100.0, 250.0, 500.0, 2000.0, 3916.0), 2)
    assert sum(entry["kind"] == "bracket" for entry in entries) >= 6


def test_blurred_print_is_taken_for_edges_and_that_is_said(tmp_path):
    blurred = cv2.blur(page(400, 600), (25, 1))
    save(tmp_path / "page.png", np.repeat(print_photographed(blurred)[..., None], 3, axis=-1))
    found = import_photographs([tmp_path], tmp_path / "out")
    assert [entry["kind"] for entry in found.entries] == ["edge"]
    assert any("page.png: taken for print, blurred." in guess.text for guess in found.guesses)
    folder = read_captures(found.path.parent)
    assert folder.captures[0].own_edges


def test_numbers_that_no_camera_has_are_refused_together(tmp_path, capsys):
    options = ["--pixel-um", "-3", "--focal-length-mm", "0", "--bit-depth", "99", "--square-mm", "0"]
    out = tmp_path / "out"
    assert tacos_main(["captures", "import", str(tmp_path), "--out", str(out), *options]) == 2
    said = capsys.readouterr().err
    for name in ("--pixel-um: is -3", "--focal-length-mm: is 0", "--bit-depth: is 99", "--square-mm: is 0"):
        assert name in said
    assert "1 to 16 bits" in said
    assert not out.exists()
