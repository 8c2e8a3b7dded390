"""Reading folders of captures: every key of the format arrives where it belongs."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from tacos_framework.settings import check
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_gap.captures import Board, read_captures
from tacos_gap.captures.entries import CaptureCamera, CaptureEntry, FolderEntry
from tacos_gap.captures.lens_and_sensor import filters_of
from tests.docs.pages import ROOT, blocks
from tests.gap.captures.folders import CAMERA, HEIGHT, WIDTH, describe, flat_folder, noisy, save, save_frames


def test_a_flat_arrives_as_it_was_taken(tmp_path):
    capture = read_captures(flat_folder(tmp_path)).captures[0]
    assert (capture.id, capture.kind, capture.frames) == ("flat", "flat", 2)
    np.testing.assert_array_equal(capture.real_dn[..., 0], noisy())
    assert capture.real_dn.dtype == np.float32
    assert capture.expected_dn.shape == (1, HEIGHT, WIDTH, 1)
    assert (capture.expected_dn == 100.0).all()
    assert capture.valid.all()
    assert not capture.exposure_stated


def test_the_file_itself_may_be_named_instead_of_its_folder(tmp_path):
    folder = flat_folder(tmp_path)
    (tmp_path / "captures.yaml").rename(tmp_path / "other.yaml")
    assert read_captures(folder / "other.yaml").path == tmp_path


@pytest.mark.parametrize("suffix", [".png", ".tif", ".npy"])
def test_colours_are_red_green_blue_in_every_format(tmp_path, suffix):
    frames = np.zeros((2, HEIGHT, WIDTH, 3), np.uint8) + np.array([200, 100, 50], np.uint8)
    frames[:, 0] = noisy(20, channels=3)[:, 0]
    names = save_frames(tmp_path, "chart", frames, suffix)
    entry = {"id": "chart", "kind": "chart", "real": names, "simulated": 120}
    describe(tmp_path, entry, camera={**CAMERA, "channels": 3})
    capture = read_captures(tmp_path).captures[0]
    assert capture.real_dn[0, -1, -1].tolist() == [200, 100, 50]
    assert capture.expected_dn.shape == (1, HEIGHT, WIDTH, 3)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".npy"])
def test_sixteen_bit_values_are_right_aligned(tmp_path, suffix):
    frames = noisy(100).astype(np.uint16) * 40
    names = save_frames(tmp_path, "flat", frames, suffix)
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 4000}
    describe(tmp_path, entry, camera={**CAMERA, "bit_depth": 14, "black_level_dn": 64})
    capture = read_captures(tmp_path).captures[0]
    np.testing.assert_array_equal(capture.real_dn[..., 0], frames)
    assert capture.context.white_level_dn == 2**14 - 1
    assert capture.context.black_level_dn == 64


def test_a_mono_image_stored_in_colour_is_one_channel(tmp_path):
    names = save_frames(tmp_path, "flat", np.repeat(noisy()[..., None], 3, axis=-1))
    describe(tmp_path, {"id": "flat", "kind": "flat", "real": names, "simulated": 100})
    assert read_captures(tmp_path).captures[0].real_dn.shape == (2, HEIGHT, WIDTH, 1)


def test_a_glob_gives_files_in_the_order_of_their_names(tmp_path):
    flat_folder(tmp_path, frames=3, real="flat/*.png")
    np.testing.assert_array_equal(read_captures(tmp_path).captures[0].real_dn[..., 0], noisy(frames=3))


def test_frame_ten_follows_frame_nine(tmp_path):
    frames = noisy(frames=4)
    for number, frame in zip((1, 2, 10, 11), frames, strict=True):
        save(tmp_path / f"flat/shot{number}.png", frame)
    describe(tmp_path, {"id": "flat", "kind": "flat", "real": "flat/*.png", "simulated": 100})
    np.testing.assert_array_equal(read_captures(tmp_path).captures[0].real_dn[..., 0], frames)


def test_brackets_in_a_file_s_name_are_no_glob(tmp_path):
    save(tmp_path / "a[1].png", noisy()[0])
    describe(tmp_path, {"id": "flat", "kind": "flat", "real": "a[1].png", "simulated": 100})
    assert read_captures(tmp_path).captures[0].frames == 1


def test_the_expected_image_of_each_frame_of_a_sequence(tmp_path):
    frames = noisy(frames=3)
    real = save_frames(tmp_path, "moving", frames)
    expected = save_frames(
        tmp_path, "expected", np.stack([np.full((HEIGHT, WIDTH), v) for v in (90.5, 100, 110)]), ".npy"
    )
    entry = {"id": "moving", "kind": "sequence", "real": real, "simulated": expected}
    describe(
        tmp_path,
        {
            **entry,
            "velocity_px_s": [120, -5],
            "frame_interval_ms": 33,
            "row_time_us": 20,
            "row_time_reference": 6,
        },
    )
    capture = read_captures(tmp_path).captures[0]
    assert capture.expected_dn[:, 0, 0, 0].tolist() == [90.5, 100, 110]
    assert capture.context.velocity_px_s.tolist() == [120, -5]
    assert capture.context.frame_interval_s == pytest.approx(0.033)
    assert capture.context.reference_row == 6
    assert capture.row_time_us == 20


@pytest.mark.parametrize(("levels", "expectations"), [((100, 100), 1), ((100, 101), 2)])
def test_a_list_that_repeats_one_image_lets_its_frames_repeat(tmp_path, levels, expectations):
    images = np.stack([np.full((HEIGHT, WIDTH), level, np.float32) for level in levels])
    names = save_frames(tmp_path, "expected", images, ".npy")
    assert len(read_captures(flat_folder(tmp_path, simulated=names)).captures[0].expected_dn) == expectations


def test_what_a_program_holds_twice_is_read(tmp_path):
    names = save_frames(tmp_path, "flat", noisy())
    entries = [{"id": f"c{i}", "kind": "flat", "real": names, "simulated": 100} for i in range(2)]
    text = yaml.safe_dump({"tacos_captures": 1, "camera": CAMERA, "captures": entries})
    assert "*id001" in text
    (tmp_path / "captures.yaml").write_text(text)
    assert [c.frames for c in read_captures(tmp_path).captures] == [2, 2]


def test_velocity_depth_and_mask_may_vary_over_the_image(tmp_path):
    velocity = np.random.default_rng(1).normal(size=(HEIGHT, WIDTH, 2))
    depth = np.full((HEIGHT, WIDTH), 2.5, np.float32)
    depth[0] = np.inf
    mask = np.full((HEIGHT, WIDTH), 255, np.uint8)
    mask[:, 3] = 0
    save(tmp_path / "velocity.npy", velocity)
    save(tmp_path / "depth.npy", depth)
    save(tmp_path / "mask.png", mask)
    folder = flat_folder(tmp_path, velocity_px_s="velocity.npy", depth="depth.npy", mask="mask.png")
    capture = read_captures(folder).captures[0]
    np.testing.assert_array_equal(capture.context.velocity_px_s, velocity)
    np.testing.assert_array_equal(capture.context.depth_m, depth)
    np.testing.assert_array_equal(capture.valid, mask > 0)


def test_a_mask_may_be_an_array_of_switches(tmp_path):
    valid = np.arange(HEIGHT * WIDTH).reshape(HEIGHT, WIDTH) % 2 == 0
    save(tmp_path / "mask.npy", valid)
    np.testing.assert_array_equal(
        read_captures(flat_folder(tmp_path, mask="mask.npy")).captures[0].valid, valid
    )


def test_dark_frames_expect_the_pedestal_and_boards_nothing(tmp_path):
    dark = save_frames(tmp_path, "dark", noisy(16))
    board = save_frames(tmp_path, "board", noisy())
    describe(
        tmp_path,
        {"id": "dark", "kind": "dark", "real": dark, "exposure_ms": 20, "gain_db": 6, "group": "darks"},
        {"id": "board", "kind": "board", "real": board, "board": {"inner_corners": [9, 6], "square_mm": 25}},
        {"id": "edge", "kind": "edge", "real": board, "edge": {"angle_deg": 5}, "level_uncertainty": 0.02},
        camera={**CAMERA, "black_level_dn": 16, "f_number": 2.8, "cfa": "GRBG"},
    )
    dark, board, edge = read_captures(tmp_path).captures
    assert (dark.expected_dn == 16).all()
    assert dark.exposure_stated
    assert (dark.context.exposure_s, dark.context.gain_db, dark.group) == (0.02, 6, "darks")
    assert (dark.context.f_number, dark.context.cfa) == (2.8, "GRBG")
    assert board.expected_dn is None
    assert board.board == Board((9, 6), 25.0)
    assert (edge.edge_angle_deg, edge.level_uncertainty) == (5.0, 0.02)


def test_the_patches_of_a_chart(tmp_path):
    (tmp_path / "patches.csv").write_text(
        "id, x, y, width, height, r, g, b\nwhite, 1, 2, 3, 4, 200, 201.5, 202\n"
    )
    boxes, colours = (
        read_captures(flat_folder(tmp_path, chart={"patches": "patches.csv"})).captures[0].patches
    )
    assert boxes.tolist() == [[1, 2, 3, 4]]
    assert colours.tolist() == [[200, 201.5, 202]]


def test_simulated_may_itself_be_a_mean_of_noisy_frames(tmp_path):
    assert read_captures(flat_folder(tmp_path, simulated_frames=3)).captures[0].expected_frames == 3


# where the pixels lie -------------------------------------------------------------------------------------


def test_a_crop_keeps_the_sensor_s_radius_and_centre(tmp_path):
    folder = flat_folder(tmp_path, crop={"x": 30, "y": 40, "full_width_px": 80, "full_height_px": 60})
    geometry = read_captures(folder).captures[0].geometry
    assert (geometry.width_px, geometry.height_px, geometry.offset_px) == (WIDTH, HEIGHT, (30, 40))
    assert geometry.half_diagonal_px == 50
    assert geometry.centre_px == (79 / 2 - 30, 59 / 2 - 40)


def test_a_crop_of_its_own_moves_the_camera_s_principal_point_along(tmp_path):
    crop = {"x": 10, "y": 0, "full_width_px": 80, "full_height_px": 60}
    names = save_frames(tmp_path, "flat", noisy())
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 100}
    describe(
        tmp_path,
        entry,
        {**entry, "id": "moved", "crop": {**crop, "x": 15, "y": 4}},
        camera={
            **CAMERA,
            "crop": crop,
            "principal_point_px": [31.0, 28.0],
            "pixel_um": 2.0,
            "focal_length_mm": 5.0,
        },
    )
    usual, moved = (capture.geometry for capture in read_captures(tmp_path).captures)
    assert usual.centre_px == (31.0, 28.0)
    assert moved.centre_px == (26.0, 24.0)
    assert usual.focal_length_px == 2500.0
    assert usual.pixel_um == 2.0


def test_a_capture_may_have_a_size_of_its_own(tmp_path):
    save(tmp_path / "small.png", noisy()[0, :6, :10])
    describe(
        tmp_path,
        {"id": "flat", "kind": "flat", "real": "small.png", "simulated": 100, "width_px": 10, "height_px": 6},
    )
    geometry = read_captures(tmp_path).captures[0].geometry
    assert (geometry.width_px, geometry.full_width_px, geometry.centre_px) == (10, 10, (4.5, 2.5))


# noise ----------------------------------------------------------------------------------------------------


def with_noise(folder, noise, *gains_db, channels=1):
    names = save_frames(folder, "flat", noisy(channels=channels))
    entry = {"kind": "flat", "real": names, "simulated": 100}
    captures = [{**entry, "id": f"at {gain}", "gain_db": gain} for gain in gains_db]
    describe(folder, *captures, noise=noise, camera={**CAMERA, "channels": channels})
    return [capture.noise for capture in read_captures(folder).captures]


def test_noise_of_one_number_or_one_per_channel(tmp_path):
    (noise,) = with_noise(tmp_path, {"photon_dn": [0.2, 0.1, 0.3], "thermal_dn2": 1.5}, 0, channels=3)
    assert (noise.photon_dn, noise.thermal_dn2, noise.known) == ((0.2, 0.1, 0.3), (1.5,), True)


def test_each_gain_has_its_block(tmp_path):
    blocks = [
        {"photon_dn": 0.1, "thermal_dn2": 1.0},
        {"photon_dn": 0.2, "thermal_dn2": 4.0, "gain_db": 6},
    ]
    low, high = with_noise(tmp_path, blocks, 0, 6)
    assert (low.photon_dn, high.photon_dn) == ((0.1,), (0.2,))


def test_a_single_block_without_a_gain_is_that_of_the_captures(tmp_path):
    (noise,) = with_noise(tmp_path, {"photon_dn": 0.2, "thermal_dn2": 4.0}, 12)
    assert noise.photon_dn == (0.2,)


def test_unknown_noise_is_estimated_and_said_to_be(tmp_path):
    rng = np.random.default_rng(3)
    ramp = np.tile(np.linspace(20, 220, WIDTH * 8), (HEIGHT * 8, 1))
    frames = np.rint(ramp + rng.normal(size=(4, *ramp.shape)) * np.sqrt(2 + 0.3 * ramp)).astype(np.uint8)
    names = save_frames(tmp_path, "ramp", frames)
    entry = {"id": "ramp", "kind": "scene", "real": names, "simulated": 120}
    describe(tmp_path, entry, camera={"width_px": WIDTH * 8, "height_px": HEIGHT * 8}, noise="unknown")
    folder = read_captures(tmp_path)
    noise = folder.captures[0].noise
    assert not noise.known
    assert noise.photon_dn[0] == pytest.approx(0.3, rel=0.1)
    assert any("`noise` is unknown" in text for text in folder.limitations)


# recipes that render what is expected -----------------------------------------------------------------------


def test_a_scene_is_rendered_by_its_recipe_and_the_id(tmp_path):
    asked = []

    def render(path, capture):
        asked.append((path, capture))
        return np.full((1, HEIGHT, WIDTH, 1), 99.5, np.float32)

    folder = flat_folder(tmp_path, simulated=None, scene="bench.yaml")
    capture = read_captures(folder, render).captures[0]
    assert asked == [(tmp_path / "bench.yaml", "flat")]
    assert (capture.expected_dn == 99.5).all()


def test_the_example_of_the_how_to_is_of_the_right_form():
    page = ROOT / "docs" / "how-to" / "photograph_captures.md"
    (example,) = (block for block in blocks(page) if block.title == "my_captures/captures.yaml")
    document = read_yaml(example.text, name=str(page))
    entry, found, _ = check(FolderEntry, document.data, document.where)
    assert found == []
    assert {capture.kind for capture in entry.captures} == {"dark", "flat", "edge", "board"}


@pytest.mark.parametrize(
    ("camera", "filters"),
    [
        ({"width_px": 64, "height_px": 48}, "BGGR"),  # its files are whole frames
        ({"width_px": 64, "height_px": 48, "crop": {"x": 2, "y": 1}}, "GRBG"),
        ({"width_px": 16, "height_px": 12}, "RGGB"),  # where they begin is not said
    ],
)
def test_filters_of_a_crop_follow_from_where_the_camera_says_its_files_lie(camera, filters):
    full = {"full_width_px": 64, "full_height_px": 48}
    if crop := camera.get("crop"):
        camera = {**camera, "crop": {**crop, **full}}
    entry = CaptureEntry(id="wall", kind="flat", real=["a.png"], crop={"x": 3, "y": 3, **full})
    assert filters_of(CaptureCamera(cfa="RGGB", **camera), entry) == filters
