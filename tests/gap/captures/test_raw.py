"""Camera RAW: the samples as the sensor gave them. The file is a DNG made by `tests.gap.captures.dng`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tacos_files.camera_images import read_image
from tacos_framework.errors import UserError
from tacos_gap.photographs.facts import read_facts
from tests.gap.captures.dng import SHORT, dng


def test_raw_samples_come_as_they_are(tmp_path: Path) -> None:
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    samples = np.random.default_rng(0).integers(0, 65535, (64, 96)).astype(np.uint16)
    path = tmp_path / "photo.dng"
    path.write_bytes(dng(samples))
    np.testing.assert_array_equal(read_image(path, "captures.yaml:1:1")[..., 0], samples)


def test_channels_with_black_levels_of_their_own_come_with_one(tmp_path: Path) -> None:
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    blacks = np.array([[1000, 1010], [1020, 1030]], np.uint16)
    light = np.random.default_rng(0).integers(0, 50_000, (32, 48))
    light[4, 4] = 65535
    path = tmp_path / "photo.dng"
    samples = np.clip(light + np.tile(blacks, (16, 24)), 0, 65535).astype(np.uint16)
    path.write_bytes(dng(samples, {50713: (SHORT, [2, 2]), 50714: (SHORT, blacks.ravel().tolist())}))
    found = read_image(path, "captures.yaml:1:1")[..., 0].astype(int)
    assert read_facts(path).black_level_dn == 1015
    np.testing.assert_array_equal((found - 1015)[light < 60_000], light[light < 60_000])
    assert found[4, 4] == 65535


def test_a_raw_file_that_is_cut_short_is_a_fault(tmp_path: Path) -> None:
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    whole = dng(np.ones((24, 32), np.uint16))
    path = tmp_path / "photo.dng"
    # LibRaw does not miss half of the last sample.
    for length in [*range(0, len(whole) - 2, 100), len(whole) - 2]:
        path.write_bytes(whole[:length])
        with pytest.raises(UserError, match=r"photo\.dng is no RAW file that can be read"):
            read_image(path, "captures.yaml:1:1")


def test_a_raw_file_without_its_reader_names_the_extra(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "rawpy", None)
    (tmp_path / "photo.dng").write_bytes(b"")
    with pytest.raises(UserError, match=r"pip install 'tacos-framework\[raw\]'"):
        read_image(tmp_path / "photo.dng", "captures.yaml:1:1")
