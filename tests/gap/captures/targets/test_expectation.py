"""Captures without a simulator: what their own pictures expect of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.errors import UserError
from tacos_framework.formation import EpisodeDraws
from tacos_gap.captures import Noise, read_captures
from tacos_gap.captures.targets.expectation import with_own_expectations
from tacos_gap.captures.targets.photon_transfer import pooled_noise
from tacos_gap.captures.targets.wall import even_expectation, level_at
from tacos_gap.simulation.formation import simulate
from tacos_gap.statistics import Sample, measure
from tests.gap.captures.folders import describe, noisy, save_frames
from tests.gap.taken import BLACK_DN, HEIGHT, WIDTH, capture, effect, patchwork, taken

UNKNOWN = Noise((0.1,), (1.0,), known=False)


def alone(kind, level, effects=(), **changes):
    """A capture whose frames a camera with effects took, and of which nothing is expected."""
    known = [replace(capture(kind, level, frames=2), **changes)]
    return replace(taken(known, effects)[0], expected_dn=None, noise=UNKNOWN)


def test_the_level_of_a_wall_is_that_at_the_principal_point(plugins):
    wall = alone("flat", 150.0, [effect(plugins, "vignetting", k1=-0.4, k2=-0.1)])
    (found,), said = with_own_expectations([wall])
    assert said == ()
    assert found.expected_dn.shape == (1, HEIGHT, WIDTH, 1)
    assert np.ptp(found.expected_dn) == 0
    assert found.expected_dn.mean() == pytest.approx(150 + BLACK_DN, rel=0.01)
    assert found.level_uncertainty > 0


def test_the_filters_of_a_mosaic_have_levels_of_their_own():
    mosaic = np.tile(np.array([[80.0, 160.0], [160.0, 60.0]], np.float32), (60, 80))[..., None]
    assert even_expectation(mosaic, (79.5, 59.5), mosaic=True) == pytest.approx(mosaic, rel=1e-4)
    assert level_at(mosaic[..., 0], (79.5, 59.5)) == pytest.approx(115, rel=0.4)


def test_a_bracket_of_a_wall_expects_nothing_of_the_sensor_s_own_pattern(plugins):
    times_s = (0.005, 0.01, 0.02)
    pattern = [effect(plugins, "prnu", sigma=0.02), effect(plugins, "vignetting", k1=-0.2)]
    series = [
        alone("bracket", 8000 * time_s, pattern, id=f"b{k}", group="g", context=_at(time_s))
        for k, time_s in enumerate(times_s)
    ]
    found, _ = with_own_expectations(series)
    for each, time_s in zip(found, times_s, strict=True):
        expected = each.expected_dn[0, ..., 0]
        assert np.abs(np.diff(expected)).max() < 0.005 * expected.mean(), "smooth"
        assert np.ptp(expected) > 0.1 * expected.mean(), "and shaded as the wall is"
        assert expected[HEIGHT // 2, WIDTH // 2] == pytest.approx(8000 * time_s + BLACK_DN, rel=0.02)
        assert each.expected_frames == 0


@pytest.mark.parametrize(
    ("name", "settings", "acts"),
    [
        ("vignetting", {"k1": -0.3}, False),
        ("lens-distortion", {"k1": -0.2}, False),
        ("sharpening", {"amount": 1.0}, False),
        ("tone-curve", {"gamma": 2.2}, True),
        ("prnu", {"sigma": 0.02}, True),
    ],
)
def test_what_acts_alike_at_all_times_is_in_the_light_of_a_bracket(plugins, name, settings, acts):
    camera = [effect(plugins, name, **settings)]
    found, _ = with_own_expectations(bracket_of(patchwork(), [0.005, 0.01, 0.02], camera))
    for each in found:
        draws = EpisodeDraws(3, ("bracket",))
        assert np.array_equal(simulate(each, camera, draws), simulate(each, [], draws)) is not acts


@pytest.mark.parametrize(
    ("name", "settings", "acts"),
    [("vignetting", {"k1": -0.3}, False), ("lens-blur", {"sigma_px": 1.5}, True)],
)
def test_the_sides_of_an_edge_are_as_bright_as_the_lens_left_them(plugins, name, settings, acts):
    light = np.where(np.arange(WIDTH) + 0.1 * np.arange(HEIGHT)[:, None] > WIDTH / 2, 180.0, 30.0)
    (edge,), _ = with_own_expectations([alone("edge", light)])
    assert edge.own_edges
    draws, camera = EpisodeDraws(3, ("edge",)), [effect(plugins, name, **settings)]
    assert np.array_equal(simulate(edge, camera, draws), simulate(edge, [], draws)) is not acts


def test_a_bracket_of_a_scene_is_not_compared_place_by_place():
    found, _ = with_own_expectations(bracket_of(patchwork(), [0.005, 0.01, 0.02]))
    for each in found:
        taken_of = {block.statistic for block in measure(Sample(each, each.real_dn, each.expected_dn))}
        assert "level" in taken_of
        assert taken_of.isdisjoint({"relative_illumination", "detail", "displacement", "fixed_pattern"})


def bracket_of(light_dn, times_s, effects=()):
    """Captures of light as it is in the middle of the times."""
    middle_s = times_s[len(times_s) // 2]
    return [
        alone("bracket", light_dn * (t / middle_s), effects, id=f"b{k}", group="g", context=_at(t))
        for k, t in enumerate(times_s)
    ]


def test_a_bracket_expects_light_in_proportion_to_time():
    times_s = (0.005, 0.01, 0.02, 0.04)
    light = patchwork() * 0.5
    series = [
        alone("bracket", light * time_s / 0.01, id=f"b{k}", group="g", context=_at(time_s))
        for k, time_s in enumerate(times_s)
    ]
    found, said = with_own_expectations(series)
    assert said == ()
    for each, time_s in zip(found, times_s, strict=True):
        expected = each.expected_dn[0, each.valid, 0] - BLACK_DN
        assert np.median(expected / (light * time_s / 0.01)[each.valid]) == pytest.approx(1, abs=0.02)
        assert each.expected_frames == each.frames, "a scene is expected as it was seen, noise and all"


def _at(time_s):
    return replace(capture("bracket", 1.0).context, exposure_s=time_s)


def test_what_cannot_expect_anything_is_left_out_with_the_reason():
    scene = alone("scene", patchwork(), id="room")
    single = alone("bracket", patchwork(), id="once", group="g")
    clipped = alone("flat", 400.0, id="white")
    found, said = with_own_expectations([scene, single, clipped])
    assert found == ()
    assert [text.partition(":")[0] for text in said] == ["room", "once", "white"]
    assert "Give `simulated`" in said[0]
    assert "second exposure time" in said[1]
    assert "clipped" in said[2]


def test_a_wall_expects_its_light_above_the_pedestal_that_is_believed():
    """The darks lie 26 DN above it: what is left of the wall's level is light, and the rest is the error."""
    dark = alone("dark", 26.0, id="cap")
    dark = replace(dark, expected_dn=np.full((1, *dark.real_dn.shape[1:]), BLACK_DN, np.float32))
    (_, wall), _ = with_own_expectations([dark, alone("flat", 126.0, id="wall")])
    assert wall.expected_dn is not None
    assert wall.expected_dn.mean() == pytest.approx(BLACK_DN + 100.0, abs=0.3)


def test_noise_is_pooled_over_walls_of_several_levels():
    walls = [alone("flat", level) for level in (30.0, 90.0, 200.0)]
    noise = pooled_noise(walls)
    assert noise is not None
    assert noise.photon_dn[0] == pytest.approx(0.24, rel=0.05)
    assert noise.thermal_dn2[0] == pytest.approx(1.8, abs=0.5)
    assert pooled_noise(walls[:1]) is None


def test_a_folder_without_a_simulator_can_be_read(tmp_path):
    names = save_frames(tmp_path, "flat", noisy(120))
    scene = save_frames(tmp_path, "scene", noisy(np.linspace(20, 200, 20)))
    flat = {"id": "flat", "kind": "flat", "real": names}
    room = {"id": "room", "kind": "scene", "real": scene}
    folder = read_captures(describe(tmp_path, flat, room))
    assert [each.id for each in folder.captures] == ["flat"]
    assert folder.captures[0].expected_dn.mean() == pytest.approx(120, abs=2)
    assert any("room: nothing says what a scene should look like" in text for text in folder.limitations)
    with pytest.raises(UserError, match="room: nothing says"):
        read_captures(describe(tmp_path, room))
