"""Nuisances of an expectation: estimated where they are, and never so free that they swallow effects."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tacos_framework.formation import EpisodeDraws, PlacedEffect
from tacos_gap.answer.diagnosis import diagnose
from tacos_gap.answer.findings import Diagnosis
from tacos_gap.captures import CaptureFolder, RealCapture
from tacos_gap.evidence import ImageEvidence, moved_expectation, simulated_statistics
from tacos_gap.nuisances import (
    POSE_TERMS,
    Freedom,
    Marginal,
    disturbed,
    freedoms_of,
    registered,
    stated,
    with_noise_of_expectation,
)
from tacos_gap.simulation.formation import lit_by, simulate
from tests.gap.small_captures import BLACK_DN, HEIGHT, WIDTH, capture, effects_named, placed
from tests.gap.taken import patchwork

FEW = ("vignetting", "exposure-error", "defocus", "illumination-gradient", "focal-length-error", "prnu")


@pytest.fixture(scope="module")
def effects() -> dict[str, type[Any]]:
    return effects_named(*FEW, "lens-distortion")


def flats(uncertainty: float = 0.0) -> list[RealCapture]:
    levels = (40, 100, 180)
    return [
        replace(capture(f"flat_{n}", "flat", BLACK_DN + n), level_uncertainty=uncertainty) for n in levels
    ]


def scenes() -> list[RealCapture]:
    image = patchwork() + BLACK_DN
    return [
        capture("scene_a", "scene", image, frames=1),
        capture("scene_b", "scene", image[::-1, ::-1], frames=1),
    ]


def moved(each: RealCapture, dx_px: float, dy_px: float, turn_deg: float = 0.0) -> RealCapture:
    """Another pose, by SciPy's affine transform."""
    assert each.expected_dn is not None
    turn = np.radians(turn_deg)
    back = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])  # rows, columns
    centre = np.array([(HEIGHT - 1) / 2, (WIDTH - 1) / 2])
    offset = centre - back @ (centre + np.array([dy_px, dx_px]))
    planes = [
        ndimage.affine_transform(plane, back, offset, order=5, mode="nearest")
        for plane in np.moveaxis(each.expected_dn[0], -1, 0)
    ]
    return replace(each, expected_dn=np.stack(planes, axis=-1)[None].astype(np.float32))


def lit(each: RealCapture, gain: float, across: float = 0.0) -> RealCapture:
    assert each.expected_dn is not None
    light = gain * (1 + across * np.linspace(-1, 1, WIDTH, dtype=np.float32)[None, None, :, None])
    return replace(each, expected_dn=(each.expected_dn - BLACK_DN) * light + BLACK_DN)


def taken(
    expected: list[RealCapture], real: list[RealCapture], chain: list[PlacedEffect] | None = None
) -> list[RealCapture]:
    """Captures whose real frames show what `real` holds, and whose expectation is that of `expected`."""
    return [
        replace(e, real_dn=simulate(r, chain or [], EpisodeDraws(5, ("taken", i))))
        for i, (e, r) in enumerate(zip(expected, real, strict=True))
    ]


def run(captures: list[RealCapture], effects: dict[str, type[Any]]) -> Diagnosis:
    return diagnose(CaptureFolder(Path("captures"), tuple(captures)), effects, seed=3, workers=1)


# the algebra ----------------------------------------------------------------------------------------------


@given(st.integers(0, 1000), st.floats(0.01, 100))
@settings(max_examples=30, deadline=None)
def test_whitened_residuals_cost_what_the_best_nuisances_leave_prior_included(seed, size):
    rng = np.random.default_rng(seed)
    directions, nu, z = rng.normal(size=(30, 4)) * size, rng.normal(size=4), rng.normal(size=30)
    whitened = Marginal(directions, nu).whitened(z)
    linear = z + directions @ nu
    both = np.vstack([directions, np.eye(4)])
    left = np.linalg.lstsq(both, np.concatenate([linear, np.zeros(4)]), rcond=None)[1]
    assert float(whitened @ whitened) == pytest.approx(float(left[0]), rel=1e-6)


def test_nuisances_far_outside_their_prior_stay_in_the_cost():
    directions = np.full((50, 1), 20.0)
    costs = [
        float(np.sum(Marginal(directions, np.zeros(1)).whitened(directions[:, 0] * nu) ** 2))
        for nu in (0.5, 10)
    ]
    assert costs == pytest.approx([0.25, 100], rel=0.01)


def test_replicates_with_nuisances_from_the_prior_have_unit_variance():
    rng = np.random.default_rng(2)
    directions = rng.normal(size=(40, 3)) * 8
    noise, nuisances = rng.normal(size=(4000, 40)), rng.normal(size=(4000, 3))
    whitened = Marginal(directions, np.zeros(3)).spread(noise, nuisances)
    assert np.cov(whitened.T) == pytest.approx(np.eye(40), abs=0.1)


def test_wild_residuals_hardly_move_the_estimate():
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(200, 2)) * 5
    z = directions @ [1.0, -2.0] + rng.normal(size=200) * 0.5
    z[:10] += 300
    assert Marginal(directions, np.zeros(2)).most_likely(z) == pytest.approx([1, -2], abs=0.1)


# the expectation ------------------------------------------------------------------------------------------


def test_a_blur_has_the_variance_it_says():
    dot = np.zeros((HEIGHT, WIDTH))
    dot[60, 80] = 100.0
    blurred = disturbed(capture("dot", "scene", dot + BLACK_DN), [Freedom("blur_px2", 0.1)], np.array([2.0]))
    assert blurred.expected_dn is not None
    seen = blurred.expected_dn[0, :, :, 0] - BLACK_DN
    columns = np.arange(WIDTH) - 80
    assert float((seen * columns**2).sum() / seen.sum()) == pytest.approx(0.2, rel=1e-4)


def test_no_nuisance_is_the_capture_itself():
    scene = scenes()[0]
    assert disturbed(scene, freedoms_of(scene), np.zeros(len(freedoms_of(scene)))) is scene


def test_pose_is_read_off_the_pictures():
    scene = scenes()[0]
    (seen,) = taken([scene], [moved(scene, 0.7, -0.4, turn_deg=0.2)])
    freedoms = freedoms_of(seen)
    found = stated(freedoms, registered(seen, freedoms))
    assert found["shift_px"] == pytest.approx([0.7, -0.4], abs=0.04)
    assert found["rotation_deg"] == pytest.approx(0.2, abs=0.03)


def test_what_states_no_uncertain_light_has_none():
    exact, uncertain = (flats(u)[0] for u in (0.0, 0.1))
    assert freedoms_of(exact) == ()
    assert {freedom.name for freedom in freedoms_of(uncertain)} >= {"gain", "light_x"}
    assert freedoms_of(capture("dark", "dark", BLACK_DN)) == ()


# evidence -------------------------------------------------------------------------------------------------


def test_a_misregistered_scene_is_as_good_as_a_registered_one():
    scene = scenes()[0]
    (seen,) = taken([scene], [moved(scene, 0.6, 0.3, turn_deg=0.1)])
    before = ImageEvidence(seen, seed=1, replicates=6)
    after = before.renuisanced(())
    rms = [float(np.sqrt(np.mean(each._difference(()) ** 2))) for each in (before, after)]
    assert rms[0] > 4
    assert rms[1] < 1.3
    assert after.nuisances(())["shift_px"] == pytest.approx([0.6, 0.3], abs=0.05)


def count_simulations(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What is simulated from now on."""
    made: list[Any] = []

    def counted(*of: Any, **settings: Any) -> Any:
        made.append(of)
        return simulate(*of, **settings)

    monkeypatch.setattr(simulated_statistics, "simulate", counted)
    return made


@pytest.mark.parametrize("forgets", [False, True])
def test_nuisances_that_were_tried_before_are_not_simulated_again(monkeypatch, forgets):
    scene = scenes()[0]
    (seen,) = taken([scene], [moved(scene, 0.6, 0.3, turn_deg=0.1)])
    if forgets:
        monkeypatch.setattr(moved_expectation, "_KEPT", 0)
    stated = ImageEvidence(seen, seed=1, replicates=6)
    first = stated.renuisanced(())
    made = count_simulations(monkeypatch)
    again = stated.renuisanced(())
    assert bool(made) == forgets
    np.testing.assert_array_equal(again.residual(()), first.residual(()))


def test_back_at_no_nuisance_everything_is_as_it_was(monkeypatch):
    scene = scenes()[0]
    (seen,) = taken([scene], [moved(scene, 0.6, 0.3)])
    stated = ImageEvidence(seen, seed=1, replicates=6)
    moved_there = stated.renuisanced(())
    assert moved_there.real is not stated.real
    made = count_simulations(monkeypatch)
    back = moved_there._at(np.zeros_like(moved_there._nu))
    assert not made
    np.testing.assert_array_equal(back._difference(()), stated._difference(()))


def tilted(each: RealCapture, degrees: float) -> RealCapture:
    """What is seen, hung at an angle about a vertical axis: by OpenCV, from corners in a pinhole's view."""
    assert each.expected_dn is not None
    f, (cx, cy) = each.geometry.focal_length_px, each.geometry.centre_px
    corners = np.array([[0, 0], [WIDTH - 1, 0], [WIDTH - 1, HEIGHT - 1], [0, HEIGHT - 1]], np.float32)
    x, y = corners[:, 0] - cx, corners[:, 1] - cy
    depth = f + x * np.sin(np.radians(degrees))
    seen = np.column_stack([f * x * np.cos(np.radians(degrees)) / depth + cx, f * y / depth + cy])
    matrix = cv2.getPerspectiveTransform(corners, seen.astype(np.float32))
    image = cv2.warpPerspective(
        each.expected_dn[0, ..., 0],
        matrix,
        (WIDTH, HEIGHT),
        flags=cv2.INTER_LANCZOS4,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return replace(each, expected_dn=image[None, :, :, None])


def test_a_target_that_hangs_askew_is_read_off_the_pictures():
    scene = scenes()[0]
    (seen,) = taken([scene], [tilted(scene, 0.5)])
    found = ImageEvidence(seen, seed=1, replicates=6).renuisanced(())
    assert found.nuisances(())["tilt_deg"] == pytest.approx([0.5, 0.0], abs=0.15)
    assert np.sqrt(np.mean(found._difference(()) ** 2)) < 1.3


def test_targets_that_each_hang_a_little_askew_are_no_gap(effects):
    of = scenes()
    angles = np.linspace(-0.3, 0.3, len(of))
    found = run(taken(of, [tilted(each, a) for each, a in zip(of, angles, strict=True)]), effects)
    assert found.verdict == "no_gap"


def test_every_draw_of_a_noisy_colour_expectation_gives_the_same_list():
    image = np.repeat((patchwork() + BLACK_DN)[None, :, :, None], 3, axis=3).astype(np.float32)
    base = capture("chart", "chart", BLACK_DN)
    noisy = image + np.random.default_rng(1).normal(0, 2, image.shape).astype(np.float32)
    of = replace(
        base,
        expected_dn=noisy,
        real_dn=np.zeros((2, HEIGHT, WIDTH, 3), np.float32),
        noise=replace(base.noise, photon_dn=(0.24,) * 3, thermal_dn2=(1.8,) * 3),
        level_uncertainty=0.05,
        expected_frames=3,
    )
    (seen,) = taken([of], [replace(of, expected_dn=image)])
    evidence = ImageEvidence(seen, seed=1, replicates=4).renuisanced(())
    assert evidence.null_replicates.shape == (4, len(evidence.labels))
    assert np.isfinite(evidence.residual(())).all()


@pytest.mark.parametrize("said", [True, False])
def test_noise_of_the_expectation_is_nobodys_pattern(said):
    scene = scenes()[0]
    assert scene.expected_dn is not None
    spread = np.sqrt(scene.noise.variance_dn2(scene.expected_dn - BLACK_DN) / 4)
    noise = np.random.default_rng(4).normal(size=spread.shape).astype(np.float32) * spread
    noisy = replace(scene, expected_dn=scene.expected_dn + noise, expected_frames=4 if said else 0)
    (seen,) = taken([noisy], [scene])
    evidence = ImageEvidence(seen, seed=2, replicates=8).renuisanced(())
    assert float(np.sqrt(np.mean(evidence.residual(()) ** 2))) < 1.15


# the diagnosis --------------------------------------------------------------------------------------------


def few_frames(captures: list[RealCapture], frames: int, effects: list[PlacedEffect]) -> list[RealCapture]:
    """Captures with these effects, whose expectations are means of so many files without them."""
    exact = [replace(c, real_dn=np.zeros((frames, *c.real_dn.shape[1:]), np.float32)) for c in captures]
    means = [simulate(c, [], EpisodeDraws(8, ("files", i))).mean(axis=0) for i, c in enumerate(exact)]
    return [
        replace(
            c,
            real_dn=simulate(c, effects, EpisodeDraws(5, ("taken", i))),
            expected_dn=mean[None],
            expected_frames=frames,
        )
        for i, (c, mean) in enumerate(zip(captures, means, strict=True))
    ]


@pytest.fixture(scope="module")
def by_the_files() -> list[RealCapture]:
    """Flats, one of them close to white."""
    return [capture(f"flat_{n}", "flat", BLACK_DN + n, frames=4) for n in (40, 120, 231)]


def test_means_of_two_files_are_no_gap(by_the_files, effects):
    """Neither pixels chosen by their noise, nor files that white has cut off, are the camera's."""
    found = run(few_frames(by_the_files, 2, []), effects)
    assert found.verdict == "no_gap"


def test_a_fixed_pattern_shows_beside_means_of_two_files(by_the_files, effects):
    real = few_frames(by_the_files, 2, [placed("prnu", effects["prnu"], sigma=0.03)])
    (cause,) = run(real, effects).causes
    assert cause.effect == "prnu"
    sigma = cause.parameters["sigma"]
    assert sigma.value == pytest.approx(0.03, rel=0.1)
    assert sigma.interval is not None
    luck_of_maps = 1.64 * 0.03 / np.sqrt(WIDTH * HEIGHT)
    assert sigma.interval[1] - sigma.value > luck_of_maps


@pytest.mark.parametrize("level_dn", [254.0, 260.0, 400.0])
def test_noise_of_the_expectation_ends_where_files_do(level_dn):
    """Real frames with it are as those of a noisier light that white cuts off, and not noisy white."""
    share = 1.0
    before = capture("bright", "scene", level_dn, frames=1)
    sigma = float(np.sqrt(before.noise.variance_dn2(np.float32(level_dn - BLACK_DN))[0]))
    rng = np.random.default_rng(2)
    light = level_dn + sigma * rng.normal(size=before.real_dn.shape)
    real = np.clip(light, 0, 255).astype(np.float32)
    found = with_noise_of_expectation(replace(before, real_dn=real), np.random.default_rng(3), share)
    wanted = np.clip(light + np.sqrt(share) * sigma * rng.normal(size=light.shape), 0, 255)
    assert found is not None
    assert found.mean() == pytest.approx(wanted.mean(), abs=0.1)
    assert found.std() == pytest.approx(wanted.std(), abs=0.1)


def test_misregistration_drowns_no_vignetting_that_flats_prove(effects):
    clean = [*flats(), *scenes()]
    poses = [*flats(), moved(scenes()[0], 0.6, 0.35, 0.1), moved(scenes()[1], -0.5, 0.5, -0.1)]
    found = run(taken(clean, poses, [placed("vignetting", effects["vignetting"], k1=-0.3)]), effects)
    assert [cause.effect for cause in found.causes] == ["vignetting"]
    assert found.causes[0].present > 0.9
    assert found.causes[0].parameters["k1"].value == pytest.approx(-0.3, abs=0.015)
    assert found.as_data()["nuisances"]["scene_a"]["shift_px"] == pytest.approx([0.6, 0.35], abs=0.06)


def test_an_uncertain_lamp_biases_no_vignetting(effects):
    lamps = [
        lit(each, *light)
        for each, light in zip(flats(), ((1.1, 0.04), (0.92, 0), (1.05, -0.03)), strict=True)
    ]
    found = run(taken(flats(0.1), lamps, [placed("vignetting", effects["vignetting"], k1=-0.3)]), effects)
    assert [cause.effect for cause in found.causes] == ["vignetting"]
    value, interval = found.causes[0].parameters["k1"].value, found.causes[0].parameters["k1"].interval
    assert value == pytest.approx(-0.3, abs=0.01)
    assert interval is not None
    assert interval[0] < -0.3 < interval[1]


def test_a_lamp_far_brighter_than_stated_is_allowed_for_and_said(effects):
    of = [replace(each, level_uncertainty=0.05) for each in flats(0.05)]
    only = {"vignetting": effects["vignetting"]}
    bright, fair = (run(taken(of, [lit(each, gain) for each in of]), only) for gain in (1.18, 1.04))
    assert [text for text in fair.limitations if "level_uncertainty" in text] == []
    (said,) = [text for text in bright.limitations if "level_uncertainty" in text]
    assert said.startswith(f"{of[0].id}, {of[1].id}")
    assert "% above what is expected" in said


@pytest.mark.parametrize(
    ("name", "settings", "of"),
    [
        ("exposure-error", {"scale": 1.2}, flats(0.02)),
        ("illumination-gradient", {"gx": 0.3}, flats(0.02)),
        ("focal-length-error", {"scale": 1.02}, scenes()),
        ("lens-distortion", {"p2": 0.02}, scenes()),
        ("defocus", {"radius_px": 1.6}, scenes()),
    ],
)
def test_an_effect_of_a_nuisances_shape_is_still_found(effects, name, settings, of):
    """Several captures split them: each would have to be off by far more than its prior allows."""
    found = run(taken(of, of, [placed(name, effects[name], **settings)]), effects)
    assert found.causes[0].effect == name
    for parameter, value in settings.items():
        assert found.causes[0].parameters[parameter].value == pytest.approx(value, rel=0.1)


# mosaics --------------------------------------------------------------------------------------------------

FILTERS = np.array([[0.5, 1.0], [0.3, 0.5]])  # what each photosite of a GRBG mosaic sees of white light


def mosaic_capture(dx_px: float = 0.0, dy_px: float = 0.0) -> RealCapture:
    """Waves under colour filters, moved by their formula: nothing is interpolated."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    x, y = x - dx_px, y - dy_px
    waves = 0.5 + 0.2 * np.sin(0.13 * x + 0.05 * y) + 0.2 * np.cos(0.11 * y - 0.07 * x)
    image = 160 * waves * np.tile(FILTERS, (HEIGHT // 2, WIDTH // 2))
    plain = capture("bracket", "bracket", BLACK_DN + image, frames=1)
    return replace(plain, context=replace(plain.context, cfa="GRBG"))


def test_the_pose_of_a_mosaic_is_read_off_what_it_shows():
    (seen,) = taken([mosaic_capture()], [mosaic_capture(0.6, -0.4)])
    found = stated(freedoms_of(seen), registered(seen, freedoms_of(seen)))
    assert found["shift_px"] == pytest.approx([0.6, -0.4], abs=0.05)


def test_a_mosaic_moves_colour_by_colour():
    dx_px, dy_px = 0.63, -0.44
    still, gone = mosaic_capture(), mosaic_capture(dx_px, dy_px)
    nu = np.array([dx_px, dy_px, 0.0, 0.0, 0.0, 0.0])
    found = disturbed(still, [Freedom(name, 1.0) for name in POSE_TERMS], nu)
    assert found.expected_dn is not None
    assert gone.expected_dn is not None
    inside = (0, slice(8, -8), slice(8, -8))
    assert found.expected_dn[inside] == pytest.approx(gone.expected_dn[inside], abs=0.25)


def test_blur_mixes_no_colours_of_a_mosaic(effects):
    blurred = mosaic_capture()
    still = replace(blurred, expected_dn=np.full_like(blurred.expected_dn, BLACK_DN))
    even = np.tile(160 * FILTERS, (HEIGHT // 2, WIDTH // 2)).astype(np.float32)[None, ..., None]
    disc = [placed("defocus", effects["defocus"], radius_px=3.0)]
    assert lit_by(still, disc, even, EpisodeDraws(0, ())) == pytest.approx(even, rel=1e-5)


@pytest.mark.parametrize(("dy_px", "is_news"), [(0.4, False), (4.0, True)])
def test_the_pose_of_a_mosaic_is_free_within_its_prior_alone(dy_px, is_news):
    (seen,) = taken([mosaic_capture()], [mosaic_capture(0.0, dy_px)])
    z = ImageEvidence(seen, seed=1, replicates=6).renuisanced(()).residual(())
    assert (float(np.sqrt(np.mean(z**2))) > 3) == is_news


def test_only_what_may_be_made_of_other_exposures_has_noise_beyond_a_frames():
    free = {
        kind: [f.sigma for f in freedoms_of(replace(scenes()[0], kind=kind)) if f.name == "noise_share"]
        for kind in ("bracket", "scene", "flat")
    }
    assert free == {"bracket": [1.0], "scene": [0.35], "flat": []}
