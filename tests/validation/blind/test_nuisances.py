"""What is off beside effects is off by what was drawn, and owned up to in ``captures.yaml``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image as Pillow

from tacos_gap.captures import read_captures
from tacos_validation.blind.generators import flat_scenes
from tacos_validation.blind.generators.acquisitions import charts, new_camera
from tacos_validation.blind.generators.camera import IdealCamera, IdealShot
from tacos_validation.blind.generators.capture_nuisance import CaptureNuisance
from tacos_validation.blind.generators.image_formation import seen
from tacos_validation.blind.generators.nuisances import (
    NUISANCES,
    PIPELINE,
    drawn,
    pipeline_of,
)
from tacos_validation.blind.generators.specifications import (
    CAPTURES,
    CaseSpecification,
    make_and_commit,
    reveal,
)

CAMERA = IdealCamera(128, 96, focal_px=128.0, channels=1)
ACQUISITIONS = charts(new_camera(np.random.default_rng(0), 64, 48, 1), np.random.default_rng(0))


def shot() -> IdealShot:
    return IdealShot(CAMERA, flat_scenes.natural(CAMERA, np.random.default_rng(5)), 10.0)


def test_a_camera_beside_its_place_sees_the_scene_shifted() -> None:
    ramp = IdealShot(CAMERA, lambda x, y, channel: 100 + 2 * x + 3 * y, 10.0)
    real = CaptureNuisance(shift_px=(0.8, -0.4)).real(ramp)
    np.testing.assert_allclose(seen(real, ()) - seen(ramp, ()), 2 * 0.8 - 3 * 0.4)


def test_turning_leaves_the_middle() -> None:
    believed, real = shot(), CaptureNuisance(turn_deg=0.2).real(shot())
    changed = np.abs(seen(believed, ()) - seen(real, ()))[..., 0]
    assert changed[46:50, 62:66].mean() < 0.2 * changed[:8, :8].mean() + 0.2


def test_a_board_is_where_it_is() -> None:
    board = IdealShot(CAMERA, shot().look, 10.0, has_pose=False)
    np.testing.assert_array_equal(seen(CaptureNuisance(shift_px=(1.0, 0.0)).real(board), ()), seen(board, ()))


def test_a_lamp_is_off_by_its_gain_and_slopes() -> None:
    even = IdealShot(CAMERA, flat_scenes.even(CAMERA, 0.5), 10.0)
    lit = seen(CaptureNuisance(gain=1.1, slope=(0.04, 0.0, 0.0)).real(even), ())[..., 0]
    relative = lit / seen(even, ())[..., 0]
    assert relative.mean() == pytest.approx(1.1)
    assert relative[:, -1].mean() - relative[:, 0].mean() == pytest.approx(1.1 * 0.04 * 127 / 128)


@given(name=st.sampled_from(sorted(NUISANCES)), seed=st.integers(0, 2**32))
@settings(max_examples=40, deadline=None)
def test_nothing_is_off_by_more_than_it_may(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    nuisance = NUISANCES[name]
    off = drawn(nuisance, ACQUISITIONS, rng)
    for acquisition in ACQUISITIONS:
        each = off[acquisition.id]
        assert np.hypot(*each.shift_px) <= nuisance.shift_px + 1e-12
        assert abs(each.turn_deg) <= nuisance.turn_deg
        assert abs(each.gain - 1) <= nuisance.lamp
        assert each.defocus_px <= nuisance.defocus_px
        if acquisition.kind == "dark":
            assert each.real(acquisition.shots[0]).look is acquisition.shots[0].look
    brackets = [off[a.id] for a in ACQUISITIONS if a.group]
    assert all(each == brackets[0] for each in brackets)


def test_a_camera_that_processes_does_all_of_it() -> None:
    effects = pipeline_of(NUISANCES["processed"], np.random.default_rng(0))
    assert tuple(effect.name for effect in effects) == PIPELINE
    assert NUISANCES["processed"].effects == PIPELINE


@pytest.mark.parametrize("name", NUISANCES)
def test_cases_with_nuisances_can_be_read_and_own_up(name: str, tmp_path: Path) -> None:
    spec = CaseSpecification("n", 3, "T7", (), None, "smallest", 64, 48, nuisance=name)
    truth = reveal(make_and_commit(spec, tmp_path, tmp_path / "t"), tmp_path / "t" / "n.json")
    folder = tmp_path / "n" / CAPTURES
    read_captures(folder)
    data = yaml.safe_load((folder / "captures.yaml").read_text())
    entries = {entry["id"]: entry for entry in data["captures"]}
    nuisance = NUISANCES[name]
    assert (data["camera"]["black_level_dn"] == 0) is not nuisance.pedestal
    flat = entries["flat_1"]
    assert flat.get("level_uncertainty", 0.0) == nuisance.lamp
    assert ("simulated_frames" in flat) is (nuisance.expected_frames is not None)
    assert flat["real"][0].endswith(".jpg") is (nuisance.file_quality is not None)
    with Pillow.open(folder / flat["real"][0]) as image:
        assert image.format == ("JPEG" if nuisance.file_quality else "PNG")
    assert set(truth["known"]["accept"]) == set(nuisance.effects or nuisance.may_be_called)


def test_nuisances_leave_all_else_as_it_is(tmp_path: Path) -> None:
    truths = []
    for name in ("", "lamp"):
        spec = CaseSpecification(f"c{name}", 3, "T7", ("prnu",), 8.0, "smallest", 64, 48, nuisance=name)
        commitment = make_and_commit(spec, tmp_path, tmp_path / "t")
        truths.append(reveal(commitment, tmp_path / "t" / f"c{name}.json"))
    assert truths[0]["withheld"] == truths[1]["withheld"]
    assert truths[0]["camera"] == truths[1]["camera"]
