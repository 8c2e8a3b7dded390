"""A building with glass, a fence, vertex colours and UTM coordinates, through all that users do with it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from tacos_export.dataset import FORMATS
from tests.worlds.imported import exported_labels as labels
from tests.worlds.imported.glass_house import TABLE_M, UTM_M, glass_house

FEW = {
    "nodes.world.use": "scene.imported", "nodes.world.frames": "4", "nodes.world.before_step_s": "[1.2,1.0]",
    "optimizer.evaluations": "3", "study.episodes": "2", "test.episodes": "2", "test.most_episodes": "2",
    "test.frames": "4", "compare.cameras": "[basler_dart]", "compare.evaluations": "1",
    "executor.workers": "1",
}  # fmt: skip


def run(tmp_path: Path, command: str, *words: str, **sets: str) -> str:
    """What a command says, run where light that was kept before is not found."""
    options = [word for key, value in sets.items() for word in ("--set", f"{key}={value}")]
    program = Path(sys.executable).with_name(command)
    environment = {name: value for name, value in os.environ.items() if not name.startswith("TACOS_")}
    environment["XDG_CACHE_HOME"] = str(tmp_path / "cache")
    done = subprocess.run(
        [program, *words, *options],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.slow
def test_it_is_viewed_lit_once_designed_in_and_exported(tmp_path: Path) -> None:
    file = str(glass_house(tmp_path / "house.glb"))
    viewed = run(tmp_path, "tacos", "view", "scene.imported", "--out", "view", file=file)
    assert "glass: clear surfaces are left out" in viewed
    assert "lighting " in viewed
    assert (tmp_path / "view" / "index.html").is_file()

    for name, lux, exposure_ms in (("day", "400", "1"), ("dim", "5", "30")):
        sets = {
            "nodes.world.file": file,
            "scenario.illumination_lux": lux,
            "scenario.exposure_ms": exposure_ms,
        }
        run(tmp_path, "tacos-run", "headset_quick", "--out", name, **FEW, **sets)
        assert (tmp_path / name / "report.html").is_file()

    trip = {"waypoints_m": "[[448271.6,5411935.4],[448263.4,5411935.4]]", "frame_rate_hz": "1"}
    for form in FORMATS:
        words = ("export", "dataset", "scene.imported", "--frames", "2", "--format", form, "--out", form)
        assert "lighting " not in run(tmp_path, "tacos", *words, file=file, **trip)
        out = tmp_path / form
        images = [path for path in out.rglob("*") if path.suffix in (".png", ".jpg")]
        assert images
        assert all(cv2.imread(str(path), cv2.IMREAD_UNCHANGED) is not None for path in images)
    depth = [cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in (tmp_path / "tum").rglob("depth/*.png")]
    assert all((image > 0).all() and image.max() < 12 * 5000 for image in depth)
    masks = [labels.png16_mask(tmp_path / "png16", index, "table") for index in (0, 1)]
    assert min(mask.sum() for mask in masks) > 5000
    for form, boxes_of in labels.BOXES.items():
        for index, mask in enumerate(masks):
            rows, columns = np.nonzero(mask)
            extent = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
            assert boxes_of(tmp_path / form, index, "table") == [pytest.approx(extent, abs=0.01)], form
    for form, points_of in labels.POINTS.items():
        for index, mask in enumerate(masks):
            points_m = points_of(tmp_path / form, index, mask) - UTM_M
            assert (points_m > np.array(TABLE_M[0]) - 4e-3).all(), form
            assert (points_m < np.array(TABLE_M[1]) + 4e-3).all(), form
