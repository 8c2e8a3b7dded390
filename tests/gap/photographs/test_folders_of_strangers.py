"""Folders of photographs as they lie on people's disks."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from tacos_framework.cli import tacos_main
from tacos_framework.errors import UserError
from tacos_gap.captures import read_captures
from tacos_gap.photographs.given import Given
from tacos_gap.photographs.importing import import_photographs
from tacos_gap.photographs.picture import middle_of
from tests.gap.captures.dng import LONG, dng

SHAPE = (120, 160)


def taken(path: Path, level_dn: float | np.ndarray, sigma_dn: float = 2.0, seed: int = 0) -> Path:
    """An even picture of 8 bits with noise."""
    path.parent.mkdir(parents=True, exist_ok=True)
    shape = (*SHAPE, 3) if np.size(level_dn) == 3 else SHAPE
    noisy = np.rint(level_dn + np.random.default_rng(seed).normal(0, sigma_dn, shape))
    Image.fromarray(np.clip(noisy, 0, 255).astype(np.uint8)).save(path)
    return path


def test_what_systems_leave_beside_photographs_counts_for_nothing(tmp_path):
    folder = tmp_path / "Käfer 1"
    taken(folder / "IMG 1_10ms.PNG", 120)
    for name in (".DS_Store", "Thumbs.db", "._IMG 1_10ms.PNG", "__MACOSX/IMG 1.png", ".thumbs/IMG 1.jpg"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(b"no picture")
    found = import_photographs([folder], tmp_path / "Käfer 2")
    assert [entry["real"] for entry in found.entries] == [["flat_1/IMG 1_10ms.PNG"]]
    assert not any("Passed over" in doubt for doubt in found.doubts)
    assert len(read_captures(tmp_path / "Käfer 2").captures) == 1


def test_files_that_are_passed_over_are_named(tmp_path):
    taken(tmp_path / "in/a.png", 120)
    for name in ("clip.mp4", "notes.txt"):
        (tmp_path / "in" / name).write_bytes(b"x")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert "Passed over, as no pictures that can be read: notes.txt." in found.doubts
    assert any(
        doubt.startswith("Passed over: clip.mp4. Save single frames: `ffmpeg") for doubt in found.doubts
    )
    (tmp_path / "in/a.png").unlink()
    with pytest.raises(
        UserError, match=r"no pictures; there is clip.mp4, notes.txt\n.*\n.*single frames: `ff"
    ):
        import_photographs([tmp_path / "in"], tmp_path / "other")


@pytest.mark.parametrize(
    ("name", "remedy"), [("a.jp2", "Save each as PNG or TIFF"), ("a.raw", "numpy.fromfile")]
)
def test_pictures_that_cannot_be_read_say_what_to_do(tmp_path, name, remedy):
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(UserError, match=rf"there is {name}\n.*\n.*{remedy}"):
        import_photographs([tmp_path], tmp_path / "out")


def test_links_that_lead_to_no_file_are_named(tmp_path):
    taken(tmp_path / "in/a.png", 120)
    taken(tmp_path / "elsewhere/b.png", 120)
    for name, of in (("more", "elsewhere"), ("b.png", "gone.png"), ("c.png", "in/c.png")):
        (tmp_path / "in" / name).symlink_to(tmp_path / of)
    said = "\n".join(import_photographs([tmp_path / "in"], tmp_path / "out").doubts)
    for sentence in ("Passed over: more. Links to folders", "b.png is left out", "c.png is left out"):
        assert sentence in said


@pytest.mark.parametrize("suffix", [".pgm", ".bmp", ".PPM", ".jfif", ".MPO"])
def test_files_of_other_suffixes_are_pictures(tmp_path, suffix):
    taken(tmp_path / f"in/wall{suffix}", [120, 110, 100] if suffix == ".PPM" else 120)
    assert [e["kind"] for e in import_photographs([tmp_path / "in"], tmp_path / "out").entries] == ["flat"]


def test_a_file_that_two_sources_hold_is_taken_once(tmp_path):
    path = taken(tmp_path / "in/a.png", 120)
    found = import_photographs([tmp_path / "in", path], tmp_path / "out")
    assert [entry["real"] for entry in found.entries] == [["flat_1/a.png"]]


def test_a_picture_that_only_its_reader_knows_is_imported(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    (tmp_path / "in").mkdir()
    noisy = np.random.default_rng(0).normal(900, 9, SHAPE).astype(np.uint16)
    tifffile.imwrite(tmp_path / "in/a.tif", noisy, photometric="cfa")  # Pillow does not identify it
    assert len(import_photographs([tmp_path / "in"], tmp_path / "out").entries) == 1


def test_a_recording_is_sent_to_the_diagnosis_that_reads_its_times(tmp_path):
    names = [taken(tmp_path / f"walk/0{ms}ms_0.png", 20 * ms, seed=ms).name for ms in (1, 2, 4)]
    times = tmp_path / "walk/times.csv"
    times.write_text("\n".join(["file,taken_ns", *(f"{name},{k}000000" for k, name in enumerate(names))]))
    said = import_photographs([tmp_path / "walk"], tmp_path / "recorded").doubts
    assert any("walk is a recording" in doubt and "tacos-run diagnose" in doubt for doubt in said)
    times.write_text("\n".join(["file,exposure_ms", *(f"{name},{name[1]}" for name in names)]))
    said = import_photographs([tmp_path / "walk"], tmp_path / "a_table_of_times").doubts
    assert not any("is a recording" in doubt for doubt in said)


def test_focus_steps_are_compared_with_the_sharpest_of_their_view(tmp_path):
    rng = np.random.default_rng(3)
    seen = cv2.resize(rng.uniform(20, 230, (6, 8)), None, fx=20, fy=20, interpolation=cv2.INTER_CUBIC)
    seen = np.clip(seen + rng.normal(0, 12, SHAPE), 0, 255)
    for name, sigma in (("step_0", 3.0), ("step_1", 0.0), ("step_2", 2.0)):
        blurred = cv2.GaussianBlur(seen, (0, 0), sigma) if sigma else seen
        taken(tmp_path / f"in/{name}.png", blurred, 1.0, int(sigma))
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    expected = {entry["real"][0]: entry.get("simulated") for entry in found.entries}
    sharp = "scene_2/step_1.png"
    assert expected == {"scene_1/step_0.png": sharp, sharp: None, "scene_3/step_2.png": sharp}
    assert any("step_0.png and step_2.png: compared with step_1.png" in guess.text for guess in found.guesses)
    compared = [each for each in read_captures(tmp_path / "out").captures if each.expected_dn is not None]
    assert [each.expected_frames for each in compared] == [1, 1]


@pytest.mark.parametrize(("suffix", "brand"), [("HEIC", b"heic"), ("HIF", b"heix"), ("avif", b"avif")])
def test_a_heif_file_says_what_to_set_the_camera_to(tmp_path, suffix, brand):
    (tmp_path / f"IMG_1.{suffix}").write_bytes(b"\0\0\0 ftyp" + brand)
    with pytest.raises(
        UserError, match=rf"IMG_1.{suffix} is HEIF.*\n.*\n.*Let the camera save RAW or JPEG files"
    ):
        import_photographs([tmp_path], tmp_path / "out")


def test_files_that_cannot_be_read_are_named_and_the_others_imported(tmp_path, capsys):
    photo = taken(tmp_path / "in/wall_10ms.png", 120)
    for name, content in (
        ("IMG_1.HEIC", b"\0\0\0 ftypheic"),
        ("IMG_2.HEIC", b"\0\0\0 ftypheic"),
        ("empty.jpg", b""),
        ("half.png", photo.read_bytes()[:300]),
        ("gr\udcfcn.png", b"no picture"),
        ("sent.jpg", b"\0\0\0 ftypheic"),
    ):
        (tmp_path / "in" / name).write_bytes(content)
    np.save(tmp_path / "in/shares.npy", np.random.default_rng(0).uniform(0.4, 0.5, SHAPE))
    assert tacos_main(["captures", "import", str(tmp_path / "in"), "--out", str(tmp_path / "out")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert (
        "IMG_1.HEIC, IMG_2.HEIC and sent.jpg are left out: each is HEIF or AVIF, which cannot be read. Let "
        "the camera save RAW or JPEG files (iPhone: Settings, Camera, Formats, Most Compatible), or convert "
        "what is there to PNG or TIFF."
    ) in said
    assert (
        "empty.jpg is left out: it is no image that can be read: it is empty. Copy or save it anew." in said
    )
    assert "half.png is left out: it is no image that can be read: it breaks off in the middle." in said
    assert "gr_n.png is left out: it is no image that can be read: it is none of PNG," in said
    assert (
        "shares.npy is left out: it cannot be used: values of shares.npy run from 0.4 to 0.5. Multiply"
        in said
    )
    assert [capture.kind for capture in read_captures(tmp_path / "out").captures] == ["flat"]


def test_a_picture_of_one_pixel_warns_of_nothing(tmp_path):
    for seed in range(2):
        taken(tmp_path / f"in/wall_{seed}.png", 120, seed=seed)
    for size in ((1, 1), (1, 9), (9, 1)):
        Image.fromarray(np.full(size, 90, np.uint8)).save(tmp_path / f"in/{size[0]} by {size[1]}.png")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert "1 by 1.png is left out: it has 1 x 1 pixels, and most have 160 x 120." in found.doubts


def deep(path: Path, level_dn: float, sigma_dn: float, seed: int = 0) -> Path:
    """An even picture of a camera of 12 bits, in a file of 16."""
    path.parent.mkdir(parents=True, exist_ok=True)
    noisy = np.rint(np.random.default_rng(seed).normal(level_dn, sigma_dn, SHAPE))
    assert cv2.imwrite(str(path), np.clip(noisy, 0, 4095).astype(np.uint16))
    return path


@pytest.mark.parametrize("with_wall", [True, False])
def test_the_dark_of_a_deep_camera_is_dark_to_its_full_scale(tmp_path, with_wall):
    deep(tmp_path / "in/a_10ms.png", 168, 4)
    if with_wall:
        deep(tmp_path / "in/b_10ms.png", 2300, 30)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert [entry["kind"] for entry in found.entries] == ["dark", "flat"][: 1 + with_wall]
    assert found.camera.entry["bit_depth"] == 12
    assert found.camera.entry["black_level_dn"] == pytest.approx(168, abs=0.2)


def test_darks_alone_are_dark_to_a_camera_that_there_is(tmp_path):
    """A pedestal of 256 DN is half of 9 bits, which no camera has."""
    deep(tmp_path / "in/a_10ms.png", 256, 5)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert [entry["kind"] for entry in found.entries] == ["dark"]
    assert found.camera.entry["bit_depth"] == 12


def test_a_camera_of_ten_bits_keeps_its_ten(tmp_path):
    deep(tmp_path / "in/a_10ms.png", 40, 3)
    deep(tmp_path / "in/b_10ms.png", 800, 9)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert [entry["kind"] for entry in found.entries] == ["dark", "flat"]
    assert found.camera.entry["bit_depth"] == 10


def test_a_broken_raw_file_says_what_to_do(tmp_path):
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    (tmp_path / "a.cr3").write_bytes(b"broken")
    with pytest.raises(UserError, match=r"no RAW file that can be read: [A-Z].*\n.*\n.*Copy it anew"):
        import_photographs([tmp_path], tmp_path / "out")


def test_pictures_of_another_form_are_left_out_and_the_rest_can_be_read(tmp_path):
    for seed in range(2):
        taken(tmp_path / f"in/wall_{seed}.png", [120, 110, 100], seed=seed)
    taken(tmp_path / "in/grey.png", 12)
    deep(tmp_path / "in/deep.png", 2300, 30)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert [len(entry["real"]) for entry in found.entries] == [2]
    assert "deep.png and grey.png are left out: each has one channel, and most have three." in found.doubts
    assert read_captures(tmp_path / "out").captures[0].frames == 2


def test_eight_bits_beside_twelve_are_left_out(tmp_path):
    for seed in range(2):
        deep(tmp_path / f"in/wall_{seed}.png", 2300, 30, seed)
    taken(tmp_path / "in/preview.jpg", 140)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert "preview.jpg is left out: it has 8 bits a sample, and most have more." in found.doubts
    assert read_captures(tmp_path / "out").captures[0].frames == 2


def test_pictures_turned_by_a_program_and_thumbnails_are_left_out_for_the_larger_ones(tmp_path):
    for seed in range(2):
        wall = Image.open(taken(tmp_path / f"in/wall_{seed}.png", 120, seed=seed))
        wall.resize((80, 60)).save(tmp_path / f"in/small_{seed}.png")
    wall.transpose(Image.Transpose.ROTATE_90).save(tmp_path / "in/turned.png")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert [entry["real"] for entry in found.entries] == [["flat_1/wall_0.png", "flat_1/wall_1.png"]]
    assert found.doubts[:2] == (
        "small_0.png and small_1.png are left out: each has 80 x 60 pixels, and most have 160 x 120.",
        "turned.png is left out: it has 120 x 160 pixels, and most have 160 x 120 (turned by a program? "
        "Files are needed as the camera wrote them).",
    )


def test_a_panorama_is_doubted(tmp_path):
    (tmp_path / "in").mkdir()
    wall = np.random.default_rng(0).normal(120, 2, (100, 400))
    Image.fromarray(wall.astype(np.uint8)).save(tmp_path / "in/wide.png")
    doubts = import_photographs([tmp_path / "in"], tmp_path / "out").doubts
    assert any(
        doubt.startswith("Pictures of 400 x 100 pixels are longer than sensors are.") for doubt in doubts
    )


def test_options_and_repeated_doubts_can_be_read(tmp_path, capsys):
    """Options are not cut at their hyphens, and frames of one capture are counted each."""
    (tmp_path / "in").mkdir()
    page = np.full((100, 160, 3), 240, np.uint8)
    cv2.rectangle(page, (20, 20), (90, 60), (30, 30, 30), -1)
    cv2.circle(page, (120, 70), 20, (30, 30, 30), -1)
    for name in "abc":
        page[0, 0, 0] += 1  # else they were copies
        Image.fromarray(page).save(tmp_path / f"in/Bildschirmfoto {name}.png")
    out = tmp_path / "out"
    assert tacos_main(["captures", "import", str(tmp_path / "in"), "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    for text in (printed, (out / "captures.yaml").read_text()):
        assert "--focal-length-mm" in text
    said = " ".join(printed.split())
    names = "Bildschirmfoto a.png, Bildschirmfoto b.png and Bildschirmfoto c.png"
    assert f"- {names}: taken for sharp edges of a print." in said
    assert "3 pictures do not say how long they were exposed (Bildschirmfoto a.png, ...)" in said


def test_a_name_may_hold_a_digit_that_is_no_decimal(tmp_path):
    taken(tmp_path / "in/1²2_10ms.png", 120)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert [entry["kind"] for entry in found.entries] == ["flat"]


@pytest.mark.parametrize("level_dn", [120, 8])
def test_a_copy_is_no_second_frame(tmp_path, level_dn):
    shutil.copy(taken(tmp_path / "in/a.png", level_dn), tmp_path / "in/a (1).png")
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert "a.png is left out: it is the same, byte by byte, as a (1).png." in found.doubts
    assert read_captures(tmp_path / "out").captures[0].frames == 1


def test_darks_without_noise_are_no_copies(tmp_path):
    for name in ("a.png", "b.png"):
        taken(tmp_path / "in" / name, 0, 0.0)
    assert len(import_photographs([tmp_path / "in"], tmp_path / "out").entries[0]["real"]) == 2


def test_names_of_other_alphabets_can_be_read_and_printed(tmp_path, capsys):
    (tmp_path / "in").mkdir()
    taken(tmp_path / "a.png", 120).rename(tmp_path / "in/gr\udcfcn\n.png")  # Latin-1, from an archive
    assert tacos_main(["captures", "import", str(tmp_path / "in"), "--out", str(tmp_path / "my out")]) == 0
    printed = capsys.readouterr().out
    printed.encode("utf-8")
    assert f"captures check '{tmp_path / 'my out'}'" in printed
    assert len(read_captures(tmp_path / "my out").captures) == 1


def test_a_board_of_another_size_than_was_said_is_told_so(tmp_path):
    squares = np.kron(np.indices((6, 8)).sum(axis=0) % 2, np.ones((15, 15)))
    board = 30 + 170 * np.pad(squares, ((15, 15), (20, 20)), constant_values=1)
    path = tmp_path / "in/board.png"
    path.parent.mkdir()
    Image.fromarray(board.astype(np.uint8)).save(path)
    with pytest.raises(UserError, match=r"7 x 5 inner corners are seen, not 8 x 6 \(--board\)"):
        import_photographs([path], tmp_path / "out", Given(inner_corners=(8, 6)))


def test_values_in_the_upper_bits_of_their_files_are_doubted(tmp_path):
    image = cv2.imread(str(deep(tmp_path / "a_10ms.png", 2300, 30)), cv2.IMREAD_UNCHANGED)
    (tmp_path / "in").mkdir()
    cv2.imwrite(str(tmp_path / "in/a_10ms.png"), image * 16)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert any("Every value is a multiple of 16, as where 12 bits" in doubt for doubt in found.doubts)
    limits = read_captures(tmp_path / "out").limitations
    assert any(limit.startswith("camera: Every value is a multiple of 16") for limit in limits)


@pytest.mark.parametrize("least", [0.4, -0.01])
def test_shares_of_full_scale_are_no_digital_numbers(tmp_path, least):
    (tmp_path / "in").mkdir()
    np.save(tmp_path / "in/a_10ms.npy", np.random.default_rng(0).uniform(least, 0.5, SHAPE))
    with pytest.raises(
        UserError, match=r"run from -?0\.\d+ to 0\.5\n.*digital numbers.*\n.*Multiply by full scale"
    ):
        import_photographs([tmp_path / "in"], tmp_path / "out")


def test_more_than_the_bits_that_were_given_is_refused(tmp_path):
    deep(tmp_path / "in/a.png", 2300, 30)
    with pytest.raises(UserError, match=r"--bit-depth: is 10, and values of a.png reach .*\n.*12 or more"):
        import_photographs([tmp_path / "in"], tmp_path / "out", Given(bit_depth=10))
    deep(tmp_path / "in/a.png", 300, 5)
    with pytest.raises(UserError, match=r"--bit-depth: is 8, and values of a.png reach .*\n.*9 or more"):
        import_photographs([tmp_path / "in"], tmp_path / "out", Given(bit_depth=8))


def raw(path: Path, level_dn: float, seed: int, **more: int) -> None:
    """A DNG of 14 bits that says its black and white levels."""
    path.parent.mkdir(exist_ok=True)
    samples = np.random.default_rng(seed).normal(level_dn, 9, SHAPE).astype(np.uint16)
    tags = {"black": 50714, "white": 50717}
    path.write_bytes(dng(samples, {tags[name]: (LONG, [value]) for name, value in more.items()}))


def test_raw_files_beyond_the_white_level_they_say_can_be_read(tmp_path):
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    raw(tmp_path / "in/a_10ms.dng", 15_000, 0, white=14_000)
    raw(tmp_path / "in/b_10ms.dng", 6_000, 1, white=14_000)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert 15_000 < found.camera.entry["white_level_dn"] < 16_383
    assert read_captures(tmp_path / "out").captures[0].context.cfa == "RGGB"


def test_raw_files_that_say_no_black_level_leave_it_to_the_darks(tmp_path):
    pytest.importorskip("rawpy", reason="the extra raw is not installed")
    raw(tmp_path / "in/a_10ms.dng", 1024, 0, white=16_383)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert found.camera.entry["black_level_dn"] == pytest.approx(1024, abs=2)
    raw(tmp_path / "in/a_10ms.dng", 1024, 0, white=16_383, black=500)
    found = import_photographs([tmp_path / "in"], tmp_path / "other")
    assert any("The black level is 500 DN (the RAW files), and the darks" in each for each in found.doubts)


def test_noisy_darks_of_one_setting_are_frames_of_one_capture(tmp_path):
    for seed in range(3):
        taken(tmp_path / f"in/dark_10ms_{seed}.png", 20, sigma_dn=6, seed=seed)
    entries = import_photographs([tmp_path / "in"], tmp_path / "out").entries
    assert [(entry["kind"], len(entry["real"])) for entry in entries] == [("dark", 3)]


def test_a_folder_that_cannot_be_written_is_a_fault(tmp_path, capsys):
    photo = taken(tmp_path / "in/a.png", 120)
    assert tacos_main(["captures", "import", str(photo), "--out", str(photo / "out")]) == 2
    assert "the captures cannot be written: Not a directory" in capsys.readouterr().err


def test_photographs_that_may_only_be_read_are_imported(tmp_path):
    photo = taken(tmp_path / "in/a.png", 120)
    photo.chmod(0o444)
    (tmp_path / "in").chmod(0o555)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert len(read_captures(found.path.parent).captures) == 1
    (tmp_path / "in").chmod(0o755)


@pytest.mark.parametrize(("level_dn", "noise_dn", "within_dn"), [(15.72, 0.6, 0.02), (240.3, 3.0, 0.05)])
def test_the_level_of_a_dark_is_known_to_less_than_a_code_whatever_hot_pixels_it_has(
    level_dn, noise_dn, within_dn
):
    rng = np.random.default_rng(3)
    dark = rng.normal(level_dn, noise_dn, (240, 320))
    dark[rng.random(dark.shape) < 1e-3] += 150
    assert middle_of(np.rint(dark)) == pytest.approx(level_dn, abs=within_dn)


def test_a_dark_that_is_cut_off_at_zero_has_no_level():
    assert middle_of(np.clip(np.rint(np.random.default_rng(3).normal(-0.3, 1.0, (99, 99))), 0, None)) == 0.0


@pytest.mark.parametrize(
    ("names", "doubted"),
    [
        ("left{}.png right{}.png", True),
        ("cam0/{}.png cam1/{}.png", True),
        ("L_{}.png R_{}.png", True),
        ("leftover{}.png rightful{}.png", False),
        ("wall{}_a.png wall{}_b.png", False),
    ],
)
def test_pictures_named_as_of_two_cameras_are_doubted(tmp_path, names, doubted):
    for number in range(3):
        for camera, name in enumerate(names.format(number, number).split()):
            taken(tmp_path / "in" / name, 90 + 20 * number, seed=2 * number + camera)
    found = import_photographs([tmp_path / "in"], tmp_path / "out")
    assert any("named as of two cameras" in doubt for doubt in found.doubts) == doubted
