"""What is said of a large file while it is made ready."""

from __future__ import annotations

import logging

import pytest

from tacos_worlds.imported import progress
from tacos_worlds.imported.progress import SHARES, Telling


@pytest.fixture
def file(tmp_path):
    (tmp_path / "house.glb").write_bytes(bytes(3_000_000))
    return tmp_path / "house.glb"


def told(file, triangles, monkeypatch, caplog):
    """With two seconds from each look at the clock to the next."""
    seconds = iter(range(0, 100, 2))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(seconds)))
    with caplog.at_level(logging.INFO, logger=progress.__name__):
        telling_of = Telling(file)
        telling_of.read(triangles)
        for stage in SHARES:
            telling_of.done(stage)
    return [record.getMessage() for record in caplog.records]


def test_a_large_file_is_named_with_its_triangles_and_the_time_left(file, monkeypatch, caplog):
    lines = told(file, 3_300_000, monkeypatch, caplog)
    assert lines[:2] == ["house.glb: reading 3 MB", "house.glb: 3,300,000 triangles, read in 2 s"]
    assert lines[2] == "house.glb, 3,300,000 triangles: geometry and floor done, about 0:00:05 left"
    assert lines[-1].endswith("light done, ready after 4 s")


def test_of_a_small_one_only_the_reading_is_said(file, monkeypatch, caplog):
    assert told(file, 5000, monkeypatch, caplog) == ["house.glb: reading 3 MB"]


def test_the_shares_are_all_of_the_time():
    assert sum(SHARES.values()) == pytest.approx(1.0)
