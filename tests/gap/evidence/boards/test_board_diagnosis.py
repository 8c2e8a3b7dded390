"""Boards from corners to causes: what no pose, paper or unstated lens explains is the lens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import Board, CaptureFolder, RealCapture
from tacos_gap.evidence.boards import boards_found, evidence_of_boards
from tacos_gap.evidence.boards.unstated_lens import _calibrated, with_lens_of_boards
from tacos_plugins.effects.board_calibration import calibrated
from tests.gap.evidence.boards.drawn_boards import SQUARES, board_capture, points, pose, seen
from tests.gap.small_captures import effects_named, placed

FOCAL_PX = 536.0
VIEWS = [((0, 0), 300.0), ((25, 10), 330.0), ((-20, 25), 320.0), ((15, -30), 340.0), ((-30, -12), 330.0)]


@pytest.fixture(scope="module")
def effects() -> dict[str, Any]:
    return effects_named(
        "lens-distortion", "focal-length-error", "pose-error", "rolling-shutter", "vignetting"
    )


def views(
    *,
    noise_px: float = 0.05,
    focal_px: float = FOCAL_PX,
    true_focal_px: float = FOCAL_PX,
    sag_mm: float = 0.0,
    poses: Sequence[Any] = VIEWS,
    board: Board = SQUARES,
    unstated: Sequence[str] = (),
    seed: int = 3,
    **lens: Any,
) -> list[RealCapture]:
    """Views of a board whose paper sags, with noisy corners."""
    rng = np.random.default_rng(seed)
    printed = points(board)
    middle = printed.mean(axis=0)
    sagging = printed + sag_mm * np.array([0, 0, 1]) * ((printed[:, :1] - middle[0]) / 100) ** 2
    made = []
    for i, (tilt, distance) in enumerate(poses):
        where = seen(*pose(tilt, distance, middle), sagging, true_focal_px, **lens)
        corners = printed, where + rng.normal(0, noise_px, where.shape)
        made.append(
            board_capture(f"view {i}", board=board, focal_px=focal_px, corners=corners, unstated=unstated)
        )
    return made


def rms(captures: Sequence[RealCapture], *hypothesis: Any) -> float:
    """Root mean square of all residuals [noise floor]."""
    evidence = evidence_of_boards(captures, seed=1)
    return float(np.sqrt(np.mean(np.concatenate([e.residual(hypothesis) for e in evidence]) ** 2)))


def diagnosed(captures: Sequence[RealCapture], effects: Mapping[str, Any]) -> Diagnosis:
    return diagnose(CaptureFolder(Path("captures"), tuple(captures)), effects, seed=2, workers=1)


# nuisances ------------------------------------------------------------------------------------------------


def test_a_pinhole_is_explained_by_its_poses():
    assert rms(views(noise_px=0.0)) < 0.05


def test_what_is_left_of_noise_is_what_the_replicates_say():
    evidence = evidence_of_boards(views(noise_px=0.4), seed=1, replicates=64)
    z = np.concatenate([e.residual(()) for e in evidence])
    floor = np.concatenate([e.null_replicates for e in evidence], axis=1)
    assert np.mean(z**2) == pytest.approx(np.mean(floor**2), rel=0.15)


def test_distortion_is_left_over_and_gone_with_the_right_lens(effects):
    captures = views(noise_px=0.0, brown=(-0.3, 0, 0, 0, 0))
    assert rms(captures) > 3
    assert rms(captures, placed("lens-distortion", effects["lens-distortion"], k1=-0.3)) < 0.05
    assert rms(captures, placed("lens-distortion", effects["lens-distortion"], k1=0.3)) > 6


def test_bent_paper_is_the_boards_and_never_the_lens(effects):
    bent = views(sag_mm=3.0)
    assert rms(bent[:2]) > 3  # two views cannot tell
    assert rms(bent) < 1.1
    sag = evidence_of_boards(bent, seed=1)[0].nuisances(())["paper_sag_mm"]
    assert sag == pytest.approx(3.0, rel=0.3)
    found = diagnosed(bent, effects)
    assert (found.verdict, found.causes) == ("no_gap", [])


def test_paper_does_not_swallow_the_lens(effects):
    found = diagnosed(views(sag_mm=3.0, brown=(-0.1, 0, 0, 0, 0)), effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    assert found.causes[0].parameters["k1"].value == pytest.approx(-0.1, abs=0.006)


def test_squares_that_are_not_square_are_the_boards():
    captures = views(noise_px=0.0)
    wider = [board_capture(c.id, corners=(c.corners[0] * [1.004, 1, 1], c.corners[1])) for c in captures]
    assert rms(wider) < 0.2


def test_a_fold_of_the_lens_is_a_bad_hypothesis_and_no_crash(effects):
    folded = placed("lens-distortion", effects["lens-distortion"], k1=-60.0)
    assert rms(views(), folded) > 20


# causes ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("k1", [-0.3, 0.1])
def test_tilted_views_name_the_lens(effects, k1):
    found = diagnosed(views(brown=(k1, 0, 0, 0, 0)), effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    assert found.verdict == "explained"
    interval = found.causes[0].parameters["k1"].interval
    assert interval is not None
    assert interval[0] < k1 < interval[1]
    assert interval[1] - interval[0] < 0.03


def test_a_fisheye_is_found_as_one(effects):
    near = [(tilt, 0.4 * distance) for tilt, distance in VIEWS]
    captures = views(poses=near, focal_px=280.0, true_focal_px=280.0, fisheye=(0.02, 0, 0, 0))
    found = diagnosed(captures, effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    assert found.causes[0].settings["model"] == "fisheye"
    assert found.causes[0].parameters["k1"].value == pytest.approx(0.02, abs=0.005)


def test_a_strong_barrel_is_found_far_from_a_pinhole(effects):
    captures = views(
        focal_px=2000.0,
        true_focal_px=2000.0,
        poses=[(t, 3.5 * d) for t, d in VIEWS],
        brown=(-2.1, 4.4, 0, 0, 0),
    )
    found = diagnosed(captures, effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    assert found.causes[0].parameters["k1"].value == pytest.approx(-2.1, rel=0.1)


def test_a_focal_length_is_one_cause_on_tilted_boards_and_two_on_a_board_that_faces_the_camera(effects):
    tilted = diagnosed(views(true_focal_px=1.04 * FOCAL_PX), effects)
    assert [cause.effect for cause in tilted.causes] == ["focal-length-error"]
    assert tilted.cause_set == ("focal-length-error",)
    assert tilted.causes[0].parameters["scale"].value == pytest.approx(1.04, abs=0.005)
    facing = diagnosed(views(true_focal_px=1.04 * FOCAL_PX, poses=VIEWS[:1]), effects)
    assert set(facing.cause_set) == {"focal-length-error", "pose-error"}
    assert facing.next_capture is not None
    assert facing.next_capture.kind == "board"


def test_no_gap_on_boards_that_could_have_shown_one_leaves_no_doubt(effects):
    found = diagnosed(views(), effects)
    assert (found.verdict, found.cause_set) == ("no_gap", ())


def test_an_unstated_focal_length_is_a_nuisance_and_never_a_cause(effects):
    captures = views(
        true_focal_px=FOCAL_PX,
        focal_px=1333.0,
        unstated=("focal_length", "principal_point"),
        brown=(-0.2, 0, 0, 0, 0),
    )
    unseen = board_capture("nothing there", focal_px=1333.0, unstated=captures[0].unstated)
    folder = boards_found(CaptureFolder(Path("captures"), (*captures, unseen)))
    assert folder.captures[0].geometry.focal_length_px == pytest.approx(FOCAL_PX, rel=0.01)
    assert "the boards give 1.6" in folder.limitations[-1]
    found = diagnosed(folder.captures, effects)
    assert [cause.effect for cause in found.causes] == ["lens-distortion"]
    assert found.causes[0].parameters["k1"].value == pytest.approx(-0.2, abs=0.02)
    told = evidence_of_boards(folder.captures, seed=1)[0].nuisances(())
    assert "focal_length_px" in told


def off_centre(captures: Sequence[RealCapture], moved_px: tuple[float, float]) -> list[RealCapture]:
    """The captures of a lens that stands off the middle of the sensor, which the captures do not state."""
    return [
        replace(capture, corners=(capture.corners[0], capture.corners[1] + moved_px))
        for capture in captures
        if capture.corners is not None
    ]


@pytest.mark.parametrize("fisheye", [None, (0.03, -0.01, 0.0, 0.0)])
def test_a_stated_focal_length_leaves_the_principal_point_to_the_boards(fisheye):
    lens: dict[str, Any] = {"fisheye": fisheye} if fisheye else {"brown": (-0.2, 0.05, 0, 0, 0)}
    captures = off_centre(views(unstated=("principal_point",), **lens), (14.0, -9.0))
    found, said = with_lens_of_boards(captures)
    moved = np.subtract(found[0].geometry.centre_px, captures[0].geometry.centre_px)
    assert moved == pytest.approx((14.0, -9.0), abs=1.5)
    assert found[0].geometry.focal_length_px == FOCAL_PX
    assert said[0].startswith("principal_point_px is not stated: the boards place it at (33")
    facing = off_centre(
        views(poses=[((0, 0), 300.0), ((0, 0), 400.0)], unstated=("principal_point",)), (14, -9)
    )
    assert with_lens_of_boards(facing) == (tuple(facing), [])


def test_two_cameras_of_one_rig_get_one_model():
    """One saw boards out to its corners, the other in the middle alone, where either model fits."""
    lens, focal_px = (-0.01, 0.004, 0.0, 0.0), 300.0
    far, near = 160.0, 420.0
    wide = views(
        poses=[(tilt, far) for tilt, _ in VIEWS],
        true_focal_px=focal_px,
        fisheye=lens,
        unstated=("focal_length",),
    )
    narrow = views(
        poses=[(tilt, near) for tilt, _ in VIEWS],
        true_focal_px=focal_px,
        fisheye=lens,
        unstated=("focal_length",),
    )
    found = [_calibrated(captures, ("focal_length",)) for captures in (wide, narrow)]
    by_fisheye = [calibrated(captures, free=("focal_length",), fisheye=True) for captures in (wide, narrow)]
    assert [each and each.radial for each in found] == [each and each.radial for each in by_fisheye]


def test_views_that_face_the_camera_do_not_settle_an_unstated_focal_length():
    facing = views(poses=[((0, 0), 300.0), ((0, 0), 400.0)], unstated=("focal_length",))
    unseen = board_capture("nothing there", unstated=("focal_length",))
    folder = boards_found(CaptureFolder(Path("captures"), (*facing, unseen)))
    assert folder.captures[0].geometry.focal_length_px == FOCAL_PX
    assert "tilt them more: 1.608 mm is assumed" in folder.limitations[-1]


@pytest.mark.parametrize("sign", [-1, 1])
def test_the_stated_limit_parts_lenses_that_show_from_those_that_do_not(effects, sign):
    stated = diagnosed(views(noise_px=0.03, seed=1), effects).detectable["lens-distortion"]["k1"]
    for share, named in ((0.75, []), (1.3, ["lens-distortion"])):
        lens = (sign * share * abs(stated), 0, 0, 0, 0)
        found = diagnosed(views(noise_px=0.03, seed=5, sag_mm=sign, brown=lens), effects)
        assert [cause.effect for cause in found.causes] == named


@pytest.mark.slow
def test_lenses_beyond_the_limit_are_named_and_intervals_hold_them(effects):
    """Weak lenses too: below the limit none need be named, and none is ever another effect."""
    limits = {
        noise_px: abs(diagnosed(views(noise_px=noise_px), effects).detectable["lens-distortion"]["k1"])
        for noise_px in (0.03, 0.15)
    }
    held, beyond, named = [], 0, 0
    for seed in range(24):
        rng = np.random.default_rng(seed)
        k1 = float(rng.uniform(0.02, 0.3) * rng.choice([-1, 1]))
        noise_px = float(rng.choice([0.03, 0.15]))
        captures = views(noise_px=noise_px, sag_mm=rng.uniform(-2, 2), seed=seed, brown=(k1, 0, 0, 0, 0))
        causes = diagnosed(captures, effects).causes
        beyond += abs(k1) > 1.3 * limits[noise_px]
        named += bool(causes) and abs(k1) > 1.3 * limits[noise_px]
        for cause in causes:
            assert cause.effect == "lens-distortion"
            interval = cause.parameters["k1"].interval
            assert interval is not None
            held.append(interval[0] <= k1 <= interval[1])
    assert named == beyond >= 12
    assert np.mean(held) >= 0.85
