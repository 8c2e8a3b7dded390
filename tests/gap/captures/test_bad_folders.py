"""Bad folders of captures: each fault with its place, all at once, or a limitation that is stated."""

from __future__ import annotations

import json
import re
import time

import cv2
import numpy as np
import pytest

from tacos_framework.errors import Fault, UserError
from tacos_gap.captures import read_captures
from tacos_gap.captures.files import MAX_FRAMES
from tests.gap.captures.folders import (
    CAMERA,
    HEIGHT,
    WIDTH,
    describe,
    faults,
    flat_folder,
    noisy,
    only,
    save,
    save_frames,
)


def test_a_folder_without_captures_says_so(tmp_path):
    assert "there is no captures.yaml" in only(faults(tmp_path))
    assert "there is no such folder" in only(faults(tmp_path / "nowhere"))


@pytest.mark.parametrize(
    ("text", "looks"),
    [
        (
            "tacos: 1\nname: bench\nuse: procedure.simulate-captures",
            "a recipe, of procedure.simulate-captures",
        ),
        ("tacos: 1\nname: day\nrig: {}", "a recipe, of a study"),
        ("tacos: 1\nuse: procedure.diagnose\ncaptures: my_captures", "a recipe, of procedure.diagnose"),
        ("- {use: effect.vignetting}", "a list of effects, as --with takes"),
        ("effects: [{use: effect.vignetting}]", "a list of effects, as --with takes"),
        ("title: Lenses\nparts: {}", "a catalog of parts"),
        ("photon_dn: [1]\nthermal_dn2: [1]", "a calibration of noise"),
        ("hello", "text without keys"),
        ("a: 1\nb: 2\nc: 3\nd: 4\ne: 5", "something with the keys a, b, c, d, ..."),
    ],
)
def test_a_file_that_is_not_of_captures_is_called_what_it_looks_like(tmp_path, text, looks):
    """And nothing else is said of it: all its keys would be unknown, and all of captures.yaml's missing."""
    path = tmp_path / "it is.yaml"
    path.write_text(text)
    said = only(faults(path))
    assert f"it is.yaml: this is no captures file: it looks like {looks}\n" in said
    assert "a folder of captures, whose captures.yaml begins with tacos_captures: 1" in said
    assert "`tacos captures guide`" in said
    assert (f"`tacos-run '{path}'`" in said) == ("tacos: 1" in text)
    flat_folder(tmp_path)
    assert f"Name the folder {tmp_path}." in only(faults(path))


@pytest.mark.parametrize("text", ["", "# nothing yet\n"])
def test_an_empty_captures_file_is_called_empty(tmp_path, text):
    (tmp_path / "captures.yaml").write_text(text)
    said = only(faults(tmp_path))
    assert "captures.yaml: this file is empty\n  expected: a folder of captures" in said
    assert "`tacos captures guide`" in said


def test_a_captures_file_without_its_mark_is_still_one(tmp_path):
    (tmp_path / "captures.yaml").write_text("camera: {width_px: 20, height_px: 12}\ncaptures: []")
    assert "'tacos_captures' is missing" in only(faults(tmp_path))


def test_all_faults_come_at_once_each_with_line_and_column(tmp_path):
    save(tmp_path / "wide.png", noisy()[0].T)
    text = (
        "tacos_captures: 1\n"
        "camera: {width_px: 20, height_px: 12}\n"
        "captures:\n"
        "  - id: a\n"
        "    kind: flat\n"
        "    real: missing.png\n"
        "    simulated: 100\n"
        "  - id: b\n"
        "    kind: bracket\n"
        "    real: wide.png\n"
        "  - id: a\n"
        "    kind: board\n"
        "    real: [nothing*.png]\n"
    )
    (tmp_path / "captures.yaml").write_text(text)
    duplicate = only(faults(tmp_path))
    assert re.search(r"captures.yaml:11:5: the id 'a' stands twice", duplicate)
    (tmp_path / "captures.yaml").write_text(
        text.replace("- id: a\n    kind: board", "- id: c\n    kind: board")
    )
    found = faults(tmp_path)
    for expected in [
        r"captures.yaml:6:5: there is no file 'missing.png'",
        r"captures.yaml:8:5: 'b', a bracket, has no exposure_ms",
        r"captures.yaml:10:5: wide.png has 12 x 20 pixels\n  expected: 20 x 12",
        r"captures.yaml:11:5: 'c' does not describe its board",
        r"captures.yaml:13:5: no file matches 'nothing\*.png'",
    ]:
        assert any(re.search(expected, fault) for fault in found), (expected, found)
    assert len(found) == 5


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kind": "flatt"}, 'captures.0.kind is "flatt"'),
        ({"exposure": 10}, "unknown key 'captures.0.exposure'"),
        ({"shutter": 10}, "unknown key 'captures.0.shutter'\n  to do: Did you mean 'exposure_ms'?"),
        ({"exposure_ms": 0}, "captures.0.exposure_ms is 0"),
        ({"real": []}, "captures.0.real"),
        ({"real": ""}, "captures.0.real"),
        ({"level_uncertainty": 2}, "captures.0.level_uncertainty is 2"),
        ({"scene": "bench.yaml"}, "'flat' has both simulated and scene"),
        ({"simulated": None, "scene": "bench.yaml"}, "nothing renders recipes here"),
        ({"real": "flat"}, "flat is a folder"),
        ({"real": "a**b.png"}, "no pattern for files"),
        ({"real": "x" * 300 + ".png"}, "File name too long"),
        ({"simulated": ["a.npy", "b.npy", "c.npy"]}, "expects 3 images and has 2 frames"),
        ({"gain_db": 6}, "no block for gain_db 6"),
        ({"mask": "none.png"}, "there is no file 'none.png'"),
        (
            {"crop": {"x": 90, "full_width_px": 100, "full_height_px": 80}},
            "columns 90 .. 110 are not on a sensor",
        ),
        ({"chart": {"patches": "none.csv"}}, "there is no file 'none.csv'"),
    ],
    ids=str,
)
def test_a_wrong_entry(tmp_path, changes, message):
    folder = flat_folder(tmp_path, **changes)
    data = json.loads((folder / "captures.yaml").read_text())
    noise = [{"photon_dn": 0.1, "thermal_dn2": 1, "gain_db": 0}]
    fault = only(faults(describe(folder, *data["captures"], noise=noise)))
    assert message in fault
    assert re.match(r".*captures\.yaml:\d+:\d+: ", fault)


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        (
            {"black_level_dn": 300},
            "black_level_dn is 300, which is not below the white level of 255 DN (2**bit_depth - 1)",
        ),
        ({"black_level_dn": 90, "white_level_dn": 80}, "white level of 80 DN (white_level_dn)"),
        ({"channels": 3}, "has 1 channel\n"),
        ({"channels": 3, "cfa": "RGGB"}, "cfa is RGGB, and a mosaic has 1 channel, not 3"),
        ({"bit_depth": 20}, "camera.bit_depth is 20"),
        ({"crop": {"full_width_px": 10, "full_height_px": 10}}, "are not on a sensor of 10"),
        ({"bit_depth": 6}, "reach"),
    ],
    ids=str,
)
def test_a_wrong_camera(tmp_path, camera, message):
    names = save_frames(tmp_path, "flat", noisy(frames=1))
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 100}
    assert message in only(faults(describe(tmp_path, entry, camera={**CAMERA, **camera})))


@pytest.mark.parametrize(
    ("noise", "message"),
    [
        ({"photon_dn": -0.1, "thermal_dn2": 1}, "noise"),
        ({"photon_dn": [1, 2, 3], "thermal_dn2": 1}, "photon_dn has 3 numbers for 1 channel"),
        ([{"photon_dn": 1, "thermal_dn2": 1}] * 2, "two blocks are for gain_db 0"),
        ({"photon_dn": 1, "thermal_dn2": 1, "gain_db": 12}, "no block for gain_db 0"),
    ],
    ids=str,
)
def test_wrong_noise(tmp_path, noise, message):
    names = save_frames(tmp_path, "flat", noisy())
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 100}
    found = faults(describe(tmp_path, entry, noise=noise))
    assert found
    assert message in "\n".join(found)


@pytest.mark.parametrize(
    ("noise", "said"),
    [
        (None, "noise is null\n  expected: unknown, {photon_dn: 0.06, thermal_dn2: 4}, or a list of such"),
        (5, "noise is 5\n  expected: unknown, {photon_dn: 0.06, thermal_dn2: 4}, or a list of such"),
        ([], "noise is []\n  expected: unknown, {photon_dn"),
        ("unknow", 'noise is "unknow"\n  expected: '),
        (
            {"photon_dn": -0.1, "thermal_dn2": 1},
            "noise.photon_dn is -0.1\n  expected: ",
        ),
        (
            {"photon_dn": "0,1", "thermal_dn2": 1},
            'noise.photon_dn is "0,1"\n  expected: a number, or a list of three',
        ),
        (
            {"photon_dn": [1, 2], "thermal_dn2": 1},
            "photon_dn is [1, 2]\n  expected: a number, or a list of three",
        ),
        (
            [{"photon_dn": 1, "thermal_dn2": 1, "gain": 6}],
            "unknown key 'noise.0.gain'\n  to do: Did you mean 'gain_db'?",
        ),
        ({"photon_dn": 1}, "'noise.thermal_dn2' is missing"),
    ],
    ids=str,
)
def test_a_wrong_entry_of_noise_is_one_fault_that_says_what_it_may_be(tmp_path, noise, said):
    names = save_frames(tmp_path, "flat", noisy())
    entry = {"id": "flat", "kind": "flat", "real": names, "simulated": 100}
    assert said in only(faults(describe(tmp_path, entry, noise=noise)))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"real": 5}, "real is 5\n  expected: a file, a glob, or a list of files"),
        ({"real": []}, "real is []\n  expected: a file, a glob, or a list of files"),
        ({"real": ["a.png", 5]}, "real.1 is 5\n  expected: "),
        ({"simulated": {"a": 1}}, 'simulated is {"a": 1}\n  expected: a number, a file, or a list of files'),
        (
            {"velocity_px_s": [1]},
            "velocity_px_s is [1]\n  expected: two numbers, as in [120, 0], or a .npy file",
        ),
    ],
    ids=str,
)
def test_an_entry_that_takes_several_forms_is_one_fault(tmp_path, changes, said):
    assert said in only(faults(flat_folder(tmp_path, **changes)))


def test_one_block_of_noise_does_not_serve_two_gains(tmp_path):
    names = save_frames(tmp_path, "flat", noisy())
    entry = {"kind": "flat", "real": names, "simulated": 100}
    captures = [{**entry, "id": "a"}, {**entry, "id": "b", "gain_db": 6}]
    found = faults(describe(tmp_path, *captures, noise={"photon_dn": 0.1, "thermal_dn2": 1}))
    assert any("one block per gain_db" in fault for fault in found)


# files ----------------------------------------------------------------------------------------------------


def png() -> bytes:
    return cv2.imencode(".png", noisy()[0])[1].tobytes()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("empty.png", b"", "it is empty"),
        ("text.png", b"no image at all", "no image that can be read"),
        ("half.png", png()[:200], "breaks off in the middle"),
        ("empty.npy", b"", "is no array"),
        ("half.npy", b"\x93NUMPY\x01\x00v\x00{'descr': '<f4'", "is no array"),
        ("photo.dng", b"no photo", "RAW file"),
    ],
)
def test_a_file_that_cannot_be_read(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    entry = {"id": "flat", "kind": "flat", "real": name, "simulated": 100}
    assert message in only(faults(describe(tmp_path, entry)))


def test_arrays_never_run_code(tmp_path):
    np.save(tmp_path / "evil.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    assert "holds object" in only(faults(flat_folder(tmp_path, simulated="evil.npy")))


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.full((HEIGHT, WIDTH), np.nan, np.float32), "NaN or infinite"),
        (np.full((HEIGHT, WIDTH), np.inf, np.float32), "NaN or infinite"),
        (np.full((HEIGHT, WIDTH, 2), 100.0), "has the shape"),
        (np.full((3, HEIGHT, WIDTH, 1), 100.0), "has the shape"),
        (np.zeros((0, 0)), "has the shape"),
        (np.full((HEIGHT, WIDTH), 1j), "holds complex128"),
        (np.full((HEIGHT, WIDTH), "a"), "holds <U1"),
        (np.full((WIDTH, HEIGHT), 100.0), "has 12 x 20 pixels"),
    ],
    ids=lambda value: str(getattr(value, "shape", value)),
)
def test_an_expectation_that_is_no_image(tmp_path, array, message):
    np.save(tmp_path / "expected.npy", array)
    assert message in only(faults(flat_folder(tmp_path, simulated="expected.npy")))


@pytest.mark.parametrize(
    ("key", "array", "message"),
    [
        ("depth", np.full((HEIGHT, WIDTH), np.nan), "NaN"),
        ("depth", np.zeros((HEIGHT, WIDTH)), "depths of 0 or below"),
        ("depth", np.ones((HEIGHT, WIDTH + 1)), "has the shape"),
        ("velocity_px_s", np.full((HEIGHT, WIDTH, 2), np.inf), "NaN or infinite"),
        ("velocity_px_s", np.zeros((HEIGHT, WIDTH)), "has the shape"),
        ("mask", np.ones((HEIGHT + 1, WIDTH)), "has the shape"),
    ],
)
def test_a_map_that_does_not_fit(tmp_path, key, array, message):
    np.save(tmp_path / "map.npy", array)
    assert message in only(faults(flat_folder(tmp_path, **{key: "map.npy"})))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("id,x,y,width,height,r,g\na,0,0,2,2,1,1", "patches.csv has no column b"),
        ("id,x,y,width,height,r,g,b", "lists no patch"),
        (
            "id,x,y,width,height,r,g,b\na,0,0,2,2,1,1,1\nb,0,0,2,2,nan,1,1",
            "patches.csv:3: r is nan, not a number",
        ),
        ("id,x,y,width,height,r,g,b\na,inf,0,2,2,1,1,1", "x is inf, not a number"),
        ("id,x,y,width,height,r,g,b\na,0,0,2,2,1", "g is empty, not a number"),
        ("id,x,y,width,height,r,g,b\na,18,0,5,2,1,1,1", "at (18, 0) is not inside the image of 20 x 12"),
        ("id,x,y,width,height,r,g,b\na,0,0,0,2,1,1,1", "0 x 2 pixels"),
    ],
)
def test_a_table_of_patches_that_does_not_fit(tmp_path, rows, message):
    (tmp_path / "patches.csv").write_text(rows)
    assert message in only(faults(flat_folder(tmp_path, chart={"patches": "patches.csv"})))


def test_thousands_of_frames_are_not_read(tmp_path):
    names = save_frames(tmp_path, "flat", noisy(frames=MAX_FRAMES))
    content = (tmp_path / names[0]).read_bytes()
    for i in range(MAX_FRAMES, 3000):
        (tmp_path / f"flat/later {i}.png").write_bytes(content[:40])  # would be a fault if it were read
    entry = {"id": "flat", "kind": "flat", "real": "flat/*.png", "simulated": 100}
    began = time.perf_counter()
    folder = read_captures(describe(tmp_path, entry))
    assert time.perf_counter() - began < 5
    assert folder.captures[0].frames == MAX_FRAMES
    assert f"flat: {MAX_FRAMES} of its 3000 frames are used, the first ones." in folder.limitations


def test_a_long_sequence_keeps_frames_and_expectations_together(tmp_path):
    frames = noisy(frames=MAX_FRAMES + 3)
    real = save_frames(tmp_path, "real", frames)
    save_frames(tmp_path, "expected", frames + 1.5, ".npy")
    entry = {"id": "moving", "kind": "sequence", "real": real, "simulated": "expected/*.npy"}
    capture = read_captures(describe(tmp_path, entry)).captures[0]
    np.testing.assert_array_equal(capture.expected_dn, capture.real_dn + 1.5)


# recipes --------------------------------------------------------------------------------------------------


def test_what_is_wrong_with_a_scene_s_recipe_stands_beside_its_name(tmp_path):
    def render(path, capture):
        raise UserError(Fault("bench.yaml:3:1", "unknown key 'rigg'", "", "Did you mean 'rig'?"))

    fault = only(faults(flat_folder(tmp_path, simulated=None, scene="bench.yaml"), render=render))
    assert re.search(r"captures.yaml:\d+:\d+: bench.yaml:3:1: unknown key 'rigg'", fault)
    assert "Did you mean 'rig'?" in fault


def test_a_scene_of_another_size(tmp_path):
    def render(path, capture):
        return np.zeros((1, HEIGHT, WIDTH + 2, 1), np.float32)

    fault = only(faults(flat_folder(tmp_path, simulated=None, scene="bench.yaml"), render=render))
    assert "renders images of (12, 22, 1)" in fault


def test_captures_may_not_name_files_elsewhere(tmp_path):
    folder = tmp_path / "captures"
    folder.mkdir()
    np.save(tmp_path / "secret.npy", np.full((HEIGHT, WIDTH), 100, np.uint8))
    (folder / "link.npy").symlink_to(tmp_path / "secret.npy")
    for name in ("../secret.npy", str(tmp_path / "secret.npy"), "link.npy"):
        assert "leads out of" in only(faults(flat_folder(folder, simulated=name))), name
    described = {"id": "flat", "kind": "flat", "real": "../*.npy", "simulated": 100}
    assert "leaves the folder" in only(faults(describe(folder, described)))
    (folder / "patches.csv").symlink_to("/etc/passwd")
    assert "leads out of" in only(faults(flat_folder(folder, chart={"patches": "patches.csv"})))


def test_hidden_files_beside_frames_are_no_frames(tmp_path):
    flat_folder(tmp_path, real="flat/*.png")
    (tmp_path / "flat/._000.png").write_bytes(b"what a system keeps")
    assert read_captures(tmp_path).captures[0].frames == 2


def test_a_pattern_in_other_capitals_is_told_what_there_is(tmp_path):
    flat_folder(tmp_path, real="Flat/*.PNG")
    assert "Capitals count: there is flat/000.png." in only(faults(tmp_path))


def test_files_of_eight_bits_that_are_said_to_have_twelve_are_a_fault(tmp_path):
    entry = {"id": "flat", "kind": "flat", "real": save_frames(tmp_path, "flat", noisy(100.0, 2))}
    describe(tmp_path, entry | {"simulated": 100.0}, camera={**CAMERA, "bit_depth": 12})
    found = faults(tmp_path)
    assert len(found) == 2
    assert "has 8 bits, and bit_depth says 12" in found[0]
