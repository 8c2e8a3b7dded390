"""The simulated bench: what it expects, what it photographs, and that the two agree but for the effects."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from tacos_framework.errors import UserError
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Use
from tacos_gap.captures import read_captures, write_captures
from tacos_gap.simulation.bench import BenchSettings, CaptureBench, recipe_renderer
from tacos_plugins.effects.radial import even_polynomial

WIDTH, HEIGHT = 64, 48
RIG = {
    "use": "rig.monocular",
    "focal_length_mm": 0.4,
    "sensor": {"name": "small", "width_px": WIDTH, "height_px": HEIGHT, "pixel_um": 3.0},
}
SENSOR = {"use": "sensor.affine-noise", "black_level_dn": 16}
BOX = {"use": "scene.light-box"}
EDGES = {"use": "scene.slanted-edges", "pitch_m": 0.1, "size_m": 0.9}


def settings(*captures: dict[str, Any], **changes: Any) -> BenchSettings:
    data = {
        "rig": RIG,
        "renderer": {"use": "renderer.analytic"},
        "sensor": SENSOR,
        "gain_db": 24,
        "captures": captures,
        **changes,
    }
    return BenchSettings.model_validate(data)


def taken(plugins: Plugins, *captures: dict[str, Any], **changes: Any):
    return {c.id: c for c in CaptureBench(settings(*captures, **changes), plugins, seed=3).captures()}


# series ---------------------------------------------------------------------------------------------------


def test_levels_are_of_full_scale_above_the_pedestal(plugins):
    flats = taken(plugins, {"id": "flat", "kind": "flat", "scene": BOX, "level": [0.25, 0.5]})
    assert [c.expected_dn.mean() for c in flats.values()] == pytest.approx([16 + 239 / 4, 16 + 239 / 2])
    assert list(flats) == ["flat_25", "flat_50"]
    assert {c.group for c in flats.values()} == {None}, "the lamp was dimmed in between"


def test_a_bracket_is_taken_under_one_light(plugins):
    entry = {"id": "b", "kind": "bracket", "scene": BOX, "exposure_ms": [5, 10, 20], "level": 0.8}
    bracket = taken(plugins, entry)
    signal = [c.expected_dn.mean() - 16 for c in bracket.values()]
    assert signal == pytest.approx([0.2 * 239, 0.4 * 239, 0.8 * 239])
    assert [c.context.exposure_s for c in bracket.values()] == pytest.approx([0.005, 0.010, 0.020])
    assert {c.group for c in bracket.values()} == {"b"}


def test_expectations_are_not_clipped_and_frames_are(plugins):
    (bright,) = taken(plugins, {"id": "b", "kind": "flat", "scene": BOX, "level": 1.5}).values()
    assert bright.expected_dn.min() > 300
    assert bright.real_dn.max() == bright.real_dn.min() == 255


@pytest.mark.parametrize(
    ("captures", "message"),
    [
        (
            [{"id": "a", "kind": "flat", "scene": BOX, "level": [0.1, 0.2], "exposure_ms": [1, 2]}],
            "not in both",
        ),
        ([{"id": "a", "kind": "flat"}], "needs a scene"),
        ([{"id": "a", "kind": "dark", "scene": BOX}], "dark has none"),
        ([{"id": "a", "kind": "dark"}] * 2, "called a more than once"),
        ([], "at least 1"),
    ],
    ids=str,
)
def test_a_bench_that_makes_no_sense_is_refused(captures, message):
    with pytest.raises(ValidationError, match=message):
        settings(*captures)


# simulated and real ---------------------------------------------------------------------------------------


def test_without_effects_frames_scatter_about_what_is_expected_as_the_noise_says(plugins):
    captures = taken(
        plugins,
        {"id": "dark", "kind": "dark", "frames": 12},
        {"id": "flat", "kind": "flat", "scene": BOX, "level": 0.6, "frames": 12},
        {"id": "edges", "kind": "edge", "scene": EDGES, "frames": 12},
    )
    for capture in captures.values():
        signal = capture.expected_dn - capture.context.black_level_dn
        variance = capture.noise.variance_dn2(signal) + 1 / 12
        z = (capture.real_dn - capture.expected_dn) / np.sqrt(variance)
        assert abs(z.mean()) < 4 / np.sqrt(z.size), capture.id
        assert z.var() == pytest.approx(1.0, abs=0.03), capture.id


def test_the_noise_is_that_of_the_sensor(plugins):
    from tacos_plugins.sensors.affine_noise import AffineNoise

    bench = CaptureBench(settings({"id": "dark", "kind": "dark"}), plugins)
    noise = next(bench.captures()).noise
    levels = AffineNoise(AffineNoise.Config(black_level_dn=16)).noise_levels(bench._camera, gain_db=24)
    assert noise.photon_dn == pytest.approx(levels.photon_dn, rel=0.01)
    assert noise.thermal_dn2 == pytest.approx(levels.thermal_dn2, rel=0.03)


def test_effects_are_in_the_frames_and_not_in_what_is_expected(plugins):
    effects = [{"use": "effect.vignetting", "k1": -0.4}]
    entry = {"id": "flat", "kind": "flat", "scene": BOX, "level": 0.9, "frames": 30}
    (flat,) = taken(plugins, entry, effects=effects).values()
    assert np.ptp(flat.expected_dn) == pytest.approx(0, abs=1e-3)
    fall_off = (flat.real_dn.mean(axis=(0, 3)) - 16) / (flat.expected_dn.mean() - 16)
    np.testing.assert_allclose(fall_off, even_polynomial(flat.geometry.radius, -0.4), atol=0.02)


def test_electrons_bring_their_dark_signal_along(plugins):
    sensor = {
        "use": "sensor.emva",
        "quantum_efficiency": 0.5,
        "full_well_e": 5000,
        "read_noise_e": 20,  # more than a step of the files
        "dark_current_e_s": 400,
        "bit_depth": 8,
        "black_level_dn": 16,
    }
    entry = {"id": "dark", "kind": "dark", "exposure_ms": [10, 1000], "frames": 4}
    captures = taken(plugins, entry, sensor=sensor, gain_db=0)
    gain = 239 / 5000  # the full well fills the range above the pedestal
    assert captures["dark_10ms"].expected_dn.mean() == pytest.approx(16 + 4 * gain, abs=0.05)
    assert captures["dark_1000ms"].expected_dn.mean() == pytest.approx(16 + 400 * gain, rel=0.02)
    for capture in captures.values():
        assert capture.real_dn.mean() == pytest.approx(capture.expected_dn.mean(), abs=0.05)


def test_a_sensor_that_knows_too_little_says_what_it_lacks(plugins):
    with pytest.raises(UserError, match="quantum_efficiency"):
        taken(plugins, {"id": "dark", "kind": "dark"}, sensor={"use": "sensor.emva"})


def test_the_same_seed_gives_the_same_captures(plugins):
    entry = {"id": "t", "kind": "scene", "scene": {"use": "scene.textured-target", "texture_px": 128}}
    first, again = (taken(plugins, entry)["t"] for _ in range(2))
    np.testing.assert_array_equal(first.real_dn, again.real_dn)
    other = next(CaptureBench(settings(entry), plugins, seed=4).captures())
    assert (other.expected_dn != first.expected_dn).any()


# what each kind knows -------------------------------------------------------------------------------------


def test_a_moving_target_knows_how_it_moves(plugins):
    scene = {"use": "scene.textured-target", "texture_px": 128, "speed_m_s": 0.1, "direction_deg": 90}
    (moving,) = taken(plugins, {"id": "m", "kind": "sequence", "scene": scene, "frames": 3}).values()
    assert moving.expected_dn.shape[0] == moving.frames == 3
    focal_px = 0.4e3 / 3.0
    np.testing.assert_allclose(moving.context.velocity_px_s, [0, focal_px * 0.1 / 0.5], atol=1e-3)
    assert moving.context.frame_interval_s == pytest.approx(0.033)
    assert moving.context.reference_row == (HEIGHT - 1) / 2
    np.testing.assert_allclose(moving.context.depth_m, 0.5, atol=1e-5)


def test_boards_and_edges_know_their_figures(plugins):
    captures = taken(
        plugins,
        {
            "id": "board",
            "kind": "board",
            "scene": {"use": "scene.chessboard", "inner_corners": [7, 5], "square_mm": 20},
        },
        {"id": "edges", "kind": "edge", "scene": {**EDGES, "angle_deg": 7}},
    )
    assert captures["board"].board.inner_corners == (7, 5)
    assert captures["board"].board.square_mm == 20
    assert captures["board"].expected_dn is None
    assert captures["edges"].edge_angle_deg == 7


def test_a_scene_that_is_no_board_is_refused(plugins):
    with pytest.raises(UserError, match=r"scene\.light-box is no board"):
        taken(plugins, {"id": "board", "kind": "board", "scene": BOX})


def test_the_patches_of_a_chart_lie_inside_them(plugins):
    scene = {"use": "scene.colour-chart", "distance_m": 0.45}
    (chart,) = taken(plugins, {"id": "c", "kind": "chart", "scene": scene, "level": 0.9}).values()
    boxes, colours = chart.patches
    assert len(boxes) == 24
    for (x, y, width, height), colour in zip(boxes, colours, strict=True):
        inside = chart.expected_dn[0, y : y + height, x : x + width].reshape(-1, 3)
        np.testing.assert_allclose(inside, np.broadcast_to(colour, inside.shape), atol=0.01)
    red, green, blue = colours[14]  # the third row begins with blue, green, red
    assert red > 2 * green
    assert red > 2 * blue


# to disk and back -----------------------------------------------------------------------------------------


def test_a_folder_reads_back_without_a_limitation_but_for_what_saturates(plugins, tmp_path):
    bench = CaptureBench(
        settings(
            {"id": "dark", "kind": "dark", "frames": 2},
            {"id": "flat", "kind": "flat", "scene": BOX, "level": [0.3, 0.8], "frames": 2},
            {"id": "edges", "kind": "edge", "scene": EDGES, "frames": 2},
        ),
        plugins,
    )
    write_captures(tmp_path, bench.captures())
    folder = read_captures(tmp_path)
    assert folder.limitations == ()
    assert [c.id for c in folder.captures] == list(bench.shots)
    for capture in folder.captures:
        np.testing.assert_allclose(
            capture.expected_dn, bench.expected(bench.shots[capture.id]).signal_dn, atol=1e-4
        )


BENCH = """\
tacos: 1
name: bench
seed: 3
use: procedure.simulate-captures
rig: {use: rig.monocular, focal_length_mm: 0.4, sensor: {name: s, width_px: 64, height_px: 48, pixel_um: 3}}
renderer: {use: renderer.analytic}
sensor: {use: sensor.affine-noise, black_level_dn: 16}
gain_db: 24
captures:
  - {id: flat, kind: flat, scene: {use: scene.light-box}, level: 0.5, frames: 2}
  - {id: dark, kind: dark}
"""


def test_a_capture_that_names_a_recipe_is_rendered_from_it(plugins, tmp_path):
    (tmp_path / "bench.yaml").write_text(BENCH)
    bench = CaptureBench(
        settings({"id": "flat", "kind": "flat", "scene": BOX, "level": 0.5, "frames": 2}), plugins, 3
    )
    path = write_captures(tmp_path, bench.captures())
    rendered = path.read_text().replace("simulated: 135.5", "scene: bench.yaml")
    assert "scene: bench.yaml" in rendered
    path.write_text(rendered)
    capture = read_captures(tmp_path, recipe_renderer(plugins)).captures[0]
    np.testing.assert_allclose(capture.expected_dn, 135.5, atol=1e-3)


@pytest.mark.parametrize(
    ("recipe", "capture", "message"),
    [
        (BENCH, "flatt", "Did you mean 'flat'"),
        ("tacos: 1\nnodes: {}\n", "flat", "does not say what to photograph"),
        (BENCH.replace("rig:", "rigg:"), "flat", "unknown key 'rigg'"),
        (BENCH.replace("scene.light-box", "scene.light-bx"), "flat", "scene.light-bx"),
        (None, "flat", "there is no file"),
    ],
)
def test_a_recipe_that_cannot_render_says_why(plugins, tmp_path, recipe, capture, message):
    if recipe is not None:
        (tmp_path / "bench.yaml").write_text(recipe)
    with pytest.raises(UserError) as refused:
        recipe_renderer(plugins)(tmp_path / "bench.yaml", capture)
    assert message in str(refused.value)


def test_a_recipe_with_one_capture_serves_any_id(plugins, tmp_path):
    (tmp_path / "one.yaml").write_text(BENCH.replace("  - {id: dark, kind: dark}\n", ""))
    assert recipe_renderer(plugins)(tmp_path / "one.yaml", "mine").shape == (1, HEIGHT, WIDTH, 3)


def test_use_of_another_rig_camera_is_the_first(plugins):
    rig = {"use": "rig.stereo", "baseline_m": 0.1, "hfov_deg": 60.0, "sensor": RIG["sensor"]}
    assert (
        CaptureBench(settings({"id": "dark", "kind": "dark"}, rig=Use(**rig)), plugins)
        ._rig.cameras[0]
        .width_px
        == WIDTH
    )
