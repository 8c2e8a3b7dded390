"""Folders of photographs as they lie on people's disks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tacos_framework.errors import UserError
from tacos_gap.captures import read_captures
from tacos_gap.photographs.importing import import_photographs

SHAPE = (120, 160)


def taken(path: Path, level_dn: float | np.ndarray, sigma_dn: float = 2.0, seed: int = 0) -> Path:
    """An even picture of 8 bits with noise."""
    path.parent.mkdir(parents=True, exist_ok=True)
    shape = (*SHAPE, 3) if np.size(level_dn) == 3 else SHAPE
    noisy = np.rint(level_dn + np.random.default_rng(seed).normal(0, sigma_dn, shape))
    Image.fromarray(np.clip(noisy, 0, 255).astype(np.uint8)).save(path)
    return path


def test_what_systems_leave_beside_photographs_counts_for_nothing(tmp_path):
    folder = tmp_path / "Käfer 1"
    taken(folder / "IMG 1_10ms.PNG", 120)
    for name in (".DS_Store", "Thumbs.db", "._IMG 1_10ms.PNG", "__MACOSX/IMG 1.png", ".thumbs/IMG 1.jpg"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(b"no picture")
    found = import_photographs([folder], tmp_path / "Käfer 2")
    assert [entry["real"] for entry in found.entries] == [["flat_1/IMG 1_10ms.PNG"]]
    assert not any("Passed over" in doubt for doubt in found.doubts)
    assert len(read_captures(tmp_path / "Käfer 2").captures) == 1


def test_files_that_are_passed_over_are_named(tmp_path):
    taken(tmp_path / "in/a.png", 120)
    for name in ("clip.mp4", "notes.txt"):
        (tmp_path / "in" / name).write_bytes(b"x")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert "Passed over, as no pictures that can be read: clip.mp4, notes.txt." in found.doubts
    (tmp_path / "in/a.png").unlink()
    with pytest.raises(UserError, match=r"holds no pictures; there is clip.mp4, notes.txt"):
        import_photographs([tmp_path / "in"], tmp_path / "other")


@pytest.mark.parametrize("suffix", [".pgm", ".bmp", ".PPM"])
def test_files_of_machine_vision_are_pictures(tmp_path, suffix):
    taken(tmp_path / f"in/wall{suffix}", [120, 110, 100] if suffix == ".PPM" else 120)
    assert [e["kind"] for e in import_photographs([tmp_path / "in"], tmp_path / "out").entries] == ["flat"]


def test_a_file_that_two_sources_hold_is_taken_once(tmp_path):
    path = taken(tmp_path / "in/a.png", 120)
    found = import_photographs([tmp_path / "in", path], tmp_path / "out")
    assert [entry["real"] for entry in found.entries] == [["flat_1/a.png"]]


def test_a_picture_that_only_its_reader_knows_is_imported(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    (tmp_path / "in").mkdir()
    noisy = np.random.default_rng(0).normal(900, 9, SHAPE).astype(np.uint16)
    tifffile.imwrite(tmp_path / "in/a.tif", noisy, photometric="cfa")  # Pillow does not identify it
    assert len(import_photographs([tmp_path / "in"], tmp_path / "out").entries) == 1


def test_a_heif_file_says_what_to_set_the_camera_to(tmp_path):
    (tmp_path / "IMG_1.HEIC").write_bytes(b"\0\0\0 ftypheic")
    with pytest.raises(UserError, match=r"IMG_1.HEIC is HEIF.*\n.*\n.*Let the camera save RAW or JPEG files"):
        import_photographs([tmp_path], tmp_path / "out")
