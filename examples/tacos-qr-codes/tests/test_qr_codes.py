"""The shelf and the task do what the framework relies on, and what they are for."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import tacos_framework as tacos
from tacos_framework import FrameBatch, Object
from tacos_framework.testing import SceneConformance, TaskConformance
from tacos_framework.testing.samples import sample_capture, sample_rig

from tacos_qr_codes.reading import CLASS_NAME, QrCodes
from tacos_qr_codes.shelf import QrShelf, code_image, printed

RECIPE = Path(__file__).parents[1] / "recipes" / "shelf_reader.yaml"
TEXTS = ("BOX-000001", "BOX-000002")


def frames_with(shown: Sequence[str], frames: int = 4) -> FrameBatch:
    """Grey frames of a world with the labels `TEXTS`; the first half of them show those named."""
    capture = sample_capture(sample_rig(width_px=320, height_px=240), frames)
    world = capture.episode.world
    things = (*world.objects, *(Object(text, CLASS_NAME) for text in TEXTS))
    world = replace(world, objects=things, class_names=(*world.class_names, CLASS_NAME))
    images = np.full((frames, 240, 320, 1), 200, np.uint8)
    for i, text in enumerate(shown):
        code = cv2.resize(code_image(text), None, fx=4, fy=4, interpolation=cv2.INTER_NEAREST)
        images[: frames // 2, 40 : 40 + len(code), 20 + 150 * i : 20 + 150 * i + len(code), 0] = code
    return FrameBatch(replace(capture, episode=replace(capture.episode, world=world)), (images,))


class TestQrCodes(TaskConformance):
    component = QrCodes

    def frames(self) -> FrameBatch:
        return frames_with(TEXTS)


class TestQrShelf(SceneConformance):
    component = QrShelf
    config = {"columns": 2, "frames": 4}


@pytest.mark.parametrize(
    ("shown", "scores"),
    [
        (TEXTS, {"read_rate": 1.0, "frames_per_label": 2.0}),
        (TEXTS[:1], {"read_rate": 0.5, "frames_per_label": 1.0}),
        (["BOX-000009"], {"read_rate": 0.0, "frames_per_label": 0.0}),  # of no label: read, but wrong
    ],
)
def test_labels_count_that_are_read_rightly(shown: Sequence[str], scores: tacos.Scores) -> None:
    reader = QrCodes(QrCodes.Config()).begin(state=None)
    reader.update(frames_with(shown))
    assert reader.scores() == scores


def test_a_world_without_labels_has_no_scores() -> None:
    frames = frames_with(())
    bare = replace(frames.capture, episode=sample_capture().episode[:4])
    reader = QrCodes(QrCodes.Config()).begin(state=None)
    reader.update(FrameBatch(bare, frames.images))
    assert reader.scores() == {}


def test_what_is_printed_can_be_read_from_its_bottom_row_up() -> None:
    text, _, _ = cv2.QRCodeDetector().detectAndDecode(printed(TEXTS[0], 0.1).texture[::-1])
    assert text == TEXTS[0]


def test_its_recipe_is_checked() -> None:
    subprocess.run(["tacos-run", RECIPE, "--check"], check=True)


def test_a_narrow_lens_reads_what_a_wide_one_cannot(tmp_path: Path) -> None:
    """At 1.2 m a module of 80 mm / 29 takes 3.4 px at 5.5 mm of focal length, and 1.2 px at 2 mm."""
    rates = []
    for focal_mm in (2.0, 5.5):
        changes = {
            "design.focal_length_mm": {"between": [focal_mm, 1.01 * focal_mm]},
            "nodes.world.frames": 4,
            "nodes.world.columns": 2,
            "optimizer.evaluations": 1,
        }
        result = tacos.run(tacos.load_recipe(RECIPE, changes), out=tmp_path / f"{focal_mm}", report=False)
        rates.append(result["best"]["scores"]["codes.read_rate"])
    assert rates[0] < 0.2 < 0.8 < rates[1]
