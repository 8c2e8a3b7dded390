"""What is written is what is read."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tacos_framework.values import ImageContext, ImageGeometry, Lens
from tacos_gap.captures import Board, Noise, RealCapture, read_captures, write_captures

WIDTH, HEIGHT = 16, 12
NOISE = Noise((0.2,), (1.5,))


def capture(
    name: str = "flat", channels: int = 1, frames: int = 2, white: float = 255, **changes
) -> RealCapture:
    rng = np.random.default_rng(len(name))
    shape = (frames, HEIGHT, WIDTH, channels)
    values = {
        "id": name,
        "kind": "scene",
        "real_dn": np.rint(rng.uniform(0.2, 0.8, shape) * white).astype(np.float32),
        "expected_dn": rng.uniform(0.3, 0.7, (1, *shape[1:])).astype(np.float32) * np.float32(white),
        "valid": np.ones((HEIGHT, WIDTH), bool),
        "geometry": ImageGeometry(WIDTH, HEIGHT, 1000.0, (7.25, 5.5), 3.0),
        "context": ImageContext(exposure_s=0.01, white_level_dn=white, black_level_dn=8),
        "noise": NOISE,
        **changes,
    }
    return RealCapture(**values)


def same(first, second) -> bool:
    if isinstance(first, ImageGeometry | ImageContext):
        return all(same(getattr(first, f.name), getattr(second, f.name)) for f in fields(first))
    if isinstance(first, tuple) and first and isinstance(first[0], np.ndarray):
        return all(map(same, first, second))
    if first is None or isinstance(first, str | bool | dict | frozenset | Noise | Board | Lens):
        return first == second
    return bool(np.allclose(first, second))


def assert_round_trip(folder, *captures) -> None:
    write_captures(folder, captures)
    for written, read in zip(captures, read_captures(folder).captures, strict=True):
        read = replace(read, context=replace(read.context, charges_at_db=None))  # of the folder
        wrong = [
            f.name for f in fields(RealCapture) if not same(getattr(written, f.name), getattr(read, f.name))
        ]
        assert wrong == [], f"{written.id}: {wrong}"


@pytest.mark.parametrize("white", [255, 1023, 65535, 3000])
@pytest.mark.parametrize("channels", [1, 3])
def test_frames_of_any_depth_come_back(tmp_path, white, channels):
    assert_round_trip(tmp_path, capture(channels=channels, white=white))


def test_everything_known_of_a_capture_comes_back(tmp_path):
    rng = np.random.default_rng(0)
    context = ImageContext(
        exposure_s=0.02,
        gain_db=6.0,
        f_number=2.8,
        black_level_dn=8,
        depth_m=rng.uniform(1, 2, (HEIGHT, WIDTH)),
        velocity_px_s=rng.normal(size=(HEIGHT, WIDTH, 2)),
        frame_interval_s=0.033,
        reference_row=5.5,
        cfa="BGGR",
    )
    plain = ImageContext(exposure_s=0.01, f_number=2.8, black_level_dn=8, cfa="BGGR")
    patches = (np.array([[1, 2, 3, 4], [8, 2, 3, 4]]), np.array([[50.5, 60, 70], [80, 90, 100]]))
    full = capture(
        "full",
        context=context,
        noise=Noise((0.4,), (6.0,)),
        valid=rng.random((HEIGHT, WIDTH)) > 0.3,
        expected_dn=rng.uniform(50, 150, (2, HEIGHT, WIDTH, 1)).astype(np.float32),
        group="lamp",
        level_uncertainty=0.02,
        expected_frames=4,
        edge_angle_deg=5.0,
        patches=patches,
        row_time_us=12.0,
    )
    board = capture("board", kind="board", expected_dn=None, board=Board((9, 6), 25.0), context=plain)
    dark = capture(
        "dark", kind="dark", expected_dn=np.full((1, HEIGHT, WIDTH, 1), 8, np.float32), context=plain
    )
    assert_round_trip(
        tmp_path,
        dark,
        board,
        full,
        replace(full, id="still", context=replace(context, velocity_px_s=np.array([3.0, -1.0]))),
    )


def test_unknown_noise_stays_unknown(tmp_path):
    write_captures(tmp_path, [capture(noise=Noise((0.3,), (2.0,), known=False))])
    assert not read_captures(tmp_path).captures[0].noise.known


def test_crops_of_one_sensor_come_back(tmp_path):
    sensor = ImageGeometry(64, 48, 1000.0, (30.0, 25.0), 3.0)
    crops = [sensor.crop(x=x, y=y, width_px=WIDTH, height_px=HEIGHT) for x, y in [(0, 0), (48, 36), (5, 7)]]
    assert_round_trip(tmp_path, *(capture(f"crop {i}", geometry=g) for i, g in enumerate(crops)))


def test_samples_that_are_not_whole_numbers_come_back(tmp_path):
    assert_round_trip(
        tmp_path,
        capture(real_dn=np.random.default_rng(1).uniform(50, 60, (2, HEIGHT, WIDTH, 1)).astype(np.float32)),
    )


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.text(min_size=1, max_size=30).filter(lambda text: text.isprintable()))
def test_any_id_comes_back(tmp_path, name):
    assert_round_trip(tmp_path, capture(name))


@pytest.mark.parametrize(
    ("second", "message"),
    [
        ({"geometry": ImageGeometry(WIDTH, HEIGHT, 900.0, (7.25, 5.5), 3.0)}, "differ in focal_length_mm"),
        ({"context": ImageContext(white_level_dn=1023, black_level_dn=8)}, "differ in bit_depth"),
        ({"noise": Noise((0.9,), (1.5,))}, "have different noise"),
        ({"name": "A"}, "differ as names of folders"),
    ],
)
def test_captures_of_two_cameras_are_refused(tmp_path, second, message):
    with pytest.raises(ValueError, match=message):
        write_captures(tmp_path, [capture("a"), capture(**{"name": "b", **second})])


def test_nothing_to_write_is_refused(tmp_path):
    with pytest.raises(ValueError, match="no captures"):
        write_captures(tmp_path, [])


def test_crops_that_begin_in_another_column_have_their_filters_from_there(tmp_path):
    def of(name: str, x: int, y: int, cfa: str) -> RealCapture:
        geometry = ImageGeometry(40, 30, 1000.0, (19.5, 14.5), 3.0)
        geometry = geometry.crop(x=x, y=y, width_px=WIDTH, height_px=HEIGHT)
        return capture(name, geometry=geometry, context=ImageContext(cfa=cfa))

    crops = [of("a", 1, 2, "GRBG"), of("b", 4, 6, "RGGB"), of("c", 3, 5, "BGGR")]
    write_captures(tmp_path, crops)
    assert [each.context.cfa for each in read_captures(tmp_path).captures] == ["GRBG", "RGGB", "BGGR"]
    with pytest.raises(ValueError, match="differ in cfa"):
        write_captures(tmp_path / "other", [crops[0], of("d", 2, 2, "GRBG")])
