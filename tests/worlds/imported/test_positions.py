"""Where a file lies, in which unit, and when its recorded poses were taken."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tacos_framework.errors import UserError
from tacos_worlds.imported.doubts import (
    clear_height_m,
    doubt_of_open_height,
    doubt_of_tilt,
    doubt_of_up,
    doubts_of_height,
    likely_unit,
)
from tacos_worlds.imported.floor import Agent, find_floor, walkable
from tacos_worlds.imported.formats.file_bytes import Unreadable
from tacos_worlds.imported.formats.poses import doubt_of_time, read_poses, stamp_unit
from tacos_worlds.imported.place import geometry
from tacos_worlds.imported.reader import area_along, read_world
from tacos_worlds.imported.recorded import read_recorded
from tacos_worlds.imported.tour import draw_tour
from tacos_worlds.kit.mesh_files import read_model
from tacos_worlds.kit.models.patch import sound

CORNERS = np.array([[x, y, z] for z in (0, 2.7) for y in (0, 5) for x in (0, 7.3)], float)
AGENT = Agent(0.25, 1.8, 0.25)
QUADS = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]


def room(file: Path, offset: np.ndarray, scale: float = 1.0) -> Path:
    lines = ["v " + " ".join(f"{value:.6f}" for value in scale * corner + offset) for corner in CORNERS]
    faces = ["f " + " ".join(map(str, quad)) for quad in QUADS]
    file.write_text("\n".join([*lines, *faces]) + "\n")
    return file


def hits_in(file: Path, from_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances of rays from a place in the coordinates of the file, and its origin [m]."""
    read = read_world(file, up="z", metres_per_unit=1.0, leave_out=(), most_px=64)
    patches = [sound(surface, read.turn, 0) for surface in read.model.surfaces]
    occlusion, _ = geometry(patches)
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    rays = np.column_stack([np.cos(angle), np.sin(angle), np.sin(3 * angle)]).astype(np.float32)
    start = np.tile((from_m - read.origin_m).astype(np.float32), (len(rays), 1))
    return occlusion.first_hits(start, rays).distance_m, read.origin_m


@settings(max_examples=25, deadline=None)
@given(offset=st.tuples(*[st.floats(-1e7, 1e7)] * 3))
def test_a_building_ten_thousand_kilometres_off_is_as_exact_as_one_at_the_origin(
    tmp_path_factory: pytest.TempPathFactory, offset: tuple[float, float, float]
) -> None:
    folder, eye = tmp_path_factory.mktemp("far"), np.array([2.0, 1.5, 1.2])
    away = np.round(offset, 3)
    near, origin = hits_in(room(folder / "near.obj", np.zeros(3)), eye)
    assert not origin.any()
    far, _ = hits_in(room(folder / "far.obj", away), eye + away)
    np.testing.assert_allclose(far, near, atol=1e-3)


@settings(max_examples=8, deadline=None)
@given(offset=st.tuples(*[st.floats(-1e7, 1e7)] * 3), seed=st.integers(0, 9))
def test_ways_through_a_building_are_the_same_wherever_it_lies(
    tmp_path_factory: pytest.TempPathFactory, offset: tuple[float, float, float], seed: int
) -> None:
    """Ways of equal length are many on a grid: rounding of float32 must not choose among them."""
    folder, away, ways = tmp_path_factory.mktemp("ways"), np.round(offset, 2), []
    for name, moved in (("near", np.zeros(3)), ("far", away)):
        file = room(folder / f"{name}.obj", moved)
        read = read_world(file, up="z", metres_per_unit=1.0, leave_out=(), most_px=64)
        occlusion, _ = geometry([sound(surface, read.turn, 0) for surface in read.model.surfaces])
        floor = walkable(find_floor(occlusion, AGENT), AGENT, inside=None, start_m=None)
        ways.append(draw_tour(np.random.default_rng(seed), floor) + read.origin_m - moved)
    np.testing.assert_allclose(ways[1], ways[0], atol=1e-4)


@pytest.mark.parametrize(
    ("scale", "likely"),
    [
        (100.0, "centimetres: metres_per_unit 0.01"),
        (39.37, "inches"),
        (3.28, "in feet? (metres_per_unit 0.3048)"),
        (1.0, None),
    ],
)
def test_a_room_in_another_unit_is_doubted_with_that_unit(
    tmp_path: Path, scale: float, likely: str | None
) -> None:
    file = room(tmp_path / "room.obj", np.zeros(3), scale)
    read = read_world(file, up="z", metres_per_unit=1.0, leave_out=(), most_px=64)
    occlusion, _ = geometry([sound(surface, read.turn, 0) for surface in read.model.surfaces])
    floor_m = scale * np.array([[1.0, 1, 0], [3, 2, 0], [6, 4, 0]])
    doubts = [*doubts_of_height(clear_height_m(occlusion, floor_m), 1.0, (1.0, 2.0))]
    assert doubts == [] if likely is None else likely in doubts[0]


@given(height_m=st.floats(2.2, 4.5), unit_m=st.sampled_from([0.01, 0.001, 1000.0, 0.0254]))
def test_a_yard_in_another_unit_is_doubted_with_that_unit(height_m: float, unit_m: float) -> None:
    """Without a ceiling only towers are as high as a room in millimetres."""
    doubt, unit = doubt_of_open_height(height_m / unit_m, 1.0), likely_unit(height_m / unit_m, 1.0)
    assert unit is not None
    assert (doubt is not None and unit in doubt) == (height_m / unit_m > 100)
    assert doubt_of_open_height(height_m, 1.0) is None


@pytest.mark.parametrize(("scale", "likely"), [(1000.0, "per_unit 0.001"), (0.01, "per_unit 100")])
def test_a_room_that_none_can_walk_in_is_refused_with_the_likely_unit(
    tmp_path: Path, scale: float, likely: str
) -> None:
    file = room(tmp_path / "room.obj", np.zeros(3), scale)
    with pytest.raises(UserError, match=likely):
        read_world(file, up="z", metres_per_unit=1.0, leave_out=(), most_px=64)


def test_a_floor_that_stands_upright_is_doubted(tmp_path: Path) -> None:
    read = read_world(
        room(tmp_path / "r.obj", np.zeros(3)), up="z", metres_per_unit=1.0, leave_out=(), most_px=64
    )
    assert doubt_of_up(area_along(read.model), "z") is None
    assert "up: z" in str(doubt_of_up(area_along(read.model), "y"))


@settings(max_examples=6, deadline=None)
@given(thick_m=st.floats(1.9, 8.0), ground_m=st.floats(12, 30))
def test_agents_walk_in_rooms_and_not_in_the_ground_beneath_them(
    tmp_path_factory: pytest.TempPathFactory, thick_m: float, ground_m: float
) -> None:
    """Ground and slabs are often boxes, whose inside has a floor, a ceiling, and more room than a house."""
    file = tmp_path_factory.mktemp("slabs") / "house.stl"
    half = ground_m / 2
    boxes = [((-half, -half, -thick_m), (half, half, 0)), ((-3, -3, 2.6), (3, 3, 2.6 + thick_m))]
    boxes += [((-3, y - 0.1, 0), (3, y + 0.1, 2.6)) for y in (-3, 3)]
    boxes += [((x - 0.1, -3, 0), (x + 0.1, 3, 2.6)) for x in (-3, 3)]
    trimesh.util.concatenate([trimesh.creation.box(bounds=box) for box in boxes]).export(file)
    read = read_world(file, up="z", metres_per_unit=1.0, leave_out=(), most_px=64)
    occlusion, _ = geometry([sound(surface, read.turn, 0) for surface in read.model.surfaces])
    floor = walkable(find_floor(occlusion, AGENT), AGENT, inside=True, start_m=None)
    assert np.abs(floor.points_m[:, 2]).max() < 0.01
    assert clear_height_m(occlusion, floor.points_m) == pytest.approx(2.6, abs=0.01)


@settings(max_examples=20, deadline=None)
@given(latitude_deg=st.floats(25, 65), longitude_deg=st.floats(25, 65), heading_deg=st.floats(0, 360))
def test_a_building_in_coordinates_of_the_earth_is_doubted_and_one_turned_in_plan_is_not(
    tmp_path_factory: pytest.TempPathFactory, latitude_deg: float, longitude_deg: float, heading_deg: float
) -> None:
    file = tmp_path_factory.mktemp("earth") / "house.ply"
    in_plan = Rotation.from_euler("z", heading_deg, degrees=True)
    on_earth = Rotation.from_euler("zy", [longitude_deg, 90 - latitude_deg], degrees=True)  # z up to ECEF
    for turn, tilted in ((in_plan, False), (on_earth, True)):
        box = trimesh.creation.box(bounds=[(0, 0, 0), (7, 5, 2.7)])
        box.vertices = turn.apply(box.vertices)
        box.export(file)
        doubt = doubt_of_tilt(area_along(read_model(file, most_px=64)))
        assert (doubt is not None and "ECEF" in doubt) == tilted


def test_an_eye_above_the_ceiling_is_doubted() -> None:
    assert [*doubts_of_height(2.1, 1.0, (1.0, 2.0))] == []
    assert "lower camera_height_m" in next(doubts_of_height(1.9, 1.0, (1.0, 2.0)))
    assert [*doubts_of_height(None, 1.0, (1.0, 2.0))] == []  # under the sky


def write_poses(file: Path, stamps: list[str], speed_m: float = 0.04) -> Path:
    lines = [f"{stamp} {speed_m * i:.6f} 0 1.6 0 0 0 1" for i, stamp in enumerate(stamps)]
    file.write_text("\n".join(lines) + "\n")
    return file


@given(
    begin=st.integers(1_000_000_000, 2_000_000_000),
    step_ms=st.integers(2, 2000),
    unit=st.sampled_from(["s", "ms", "us", "ns"]),
)
def test_stamps_since_1970_tell_their_unit(begin: int, step_ms: int, unit: str) -> None:
    per_second = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    stamps = np.array([begin * per_second + i * step_ms * per_second / 1000 for i in range(5)])
    assert stamp_unit(stamps, "tum") == unit


@given(begin=st.integers(0, 10**9), step_ms=st.integers(5, 2000), form=st.sampled_from(["tum", "euroc"]))
def test_stamps_from_zero_in_nanoseconds_are_never_taken_for_seconds(
    begin: int, step_ms: int, form: str
) -> None:
    assert stamp_unit(np.array([begin + i * step_ms * 1e6 for i in range(4)]), form) == "ns"


def test_nanoseconds_in_the_layout_of_tum_are_the_same_path(tmp_path: Path) -> None:
    ns = read_poses(write_poses(tmp_path / "ns.txt", [str(14 * 10**17 + 50_000_000 * i) for i in range(60)]))
    s = read_poses(write_poses(tmp_path / "s.txt", [f"{0.05 * i:.6f}" for i in range(60)]))
    assert ns.unit == "ns"
    np.testing.assert_allclose(ns.time_s, s.time_s, atol=1e-6)
    assert doubt_of_time(ns) is None


def test_milliseconds_from_zero_are_doubted(tmp_path: Path) -> None:
    path = read_poses(write_poses(tmp_path / "ms.txt", [str(50 * i) for i in range(60)]))
    assert "milliseconds?" in str(doubt_of_time(path))


def test_numbers_of_frames_and_missing_times_are_doubted(tmp_path: Path) -> None:
    path = read_poses(write_poses(tmp_path / "frames.txt", [str(i) for i in range(60)]))
    assert "numbers of frames?" in str(doubt_of_time(path))
    file = tmp_path / "kitti.txt"
    file.write_text("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n")
    assert "10 poses a second" in str(doubt_of_time(read_poses(file)))


@given(
    order=st.permutations(list("wxyz")),
    between=st.sampled_from([" ", "\t", ",", ", ", ";"]),
    head=st.sampled_from(["", "#", "# "]),
    coded=st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]),
    turn=st.tuples(*[st.floats(-1, 1)] * 3),
)
def test_a_line_of_names_gives_the_order_of_rotations(
    tmp_path_factory: pytest.TempPathFactory,
    order: list[str],
    between: str,
    head: str,
    coded: str,
    turn: tuple[float, float, float],
) -> None:
    """Tables of other programs have TUM's names with commas, or EuRoC's without its mark."""
    rotation = Rotation.from_rotvec(turn)
    quaternion = dict(zip("xyzw", rotation.as_quat(), strict=True))
    names = between.join(["timestamp", "tx", "ty", "tz", *(f"q{part}" for part in order)])
    rows = [between.join(map(str, [0.1 * i, 1, 2, 3, *(quaternion[part] for part in order)])) for i in (0, 1)]
    file = tmp_path_factory.mktemp("poses") / "poses.csv"
    file.write_bytes("\n".join([head + names, *rows]).encode(coded))
    found = read_poses(file)
    np.testing.assert_allclose(found.poses[0, :3, :3], rotation.as_matrix(), atol=1e-9)
    assert found.time_s[-1] == pytest.approx(0.1)


def names_of(pose: str, between: str) -> str:
    """Names of ROS's fields of a pose."""
    parts = [("position", "xyz"), ("orientation", "xyzw")]
    return ",".join(between.join([pose, part, axis]) for part, axes in parts for axis in axes)


@pytest.mark.parametrize(
    ("head", "line"),
    [
        (
            f"Time,header.stamp.secs,header.stamp.nsecs,header.frame_id,{names_of('pose.pose', '.')}",
            "{s}.{ms},{s},{ms}000000,map,1,2,3,0,.6,0,.8",
        ),
        (f"header.stamp.sec,header.stamp.nanosec,{names_of('pose', '.')}", "{s},{ms}000000,1,2,3,0,.6,0,.8"),
        (f"__time,/odom/header/stamp,{names_of('/odom/pose', '/')}", "{s}.{ms},{s}.{ms},1,2,3,0,.6,0,.8"),
        ("# timestamp(s) q p v bg ba", "{s}.{ms} 0 .6 0 .8 1 2 3 0 0 0 0 0 0 0 0 0"),
        ("time;x;y;z;qx;qy;qz;qw", "{s},{ms};1,0;2,0;3,0;0;0,6;0;0,8"),
        ("secs,nsecs,x,y,z,qx,qy,qz,qw", "{s},{ms}000000,1,2,3,0,.6,0,.8"),
        ("# pose format: timestamp tx ty tz qx qy qz qw", "{s}.{ms} 1 2 3 0 .6 0 .8"),
        ("# timestamp position quaternion (w, x, y, z)", "{s}.{ms} 1 2 3 .8 0 .6 0"),
        ("time [s],x [cm],y [mm],z,qx,qy,qz,qw", "{s}.{ms},100,2000,3,0,.6,0,.8"),
        ("time_s,x_cm,y_mm,z_m,qx,qy,qz,qw", "{s}.{ms},100,2000,3,0,.6,0,.8"),
        ("timestamp,x,y,z,qx,qy,qz,qw", "2024-05-01T12:00:00.{ms}Z,1,2,3,0,.6,0,.8"),
        ("# time x y z qx qy qz qw", "2024-05-01 12:00:00.{ms} 1 2 3 0 .6 0 .8"),
    ],
    ids=[
        *("bagpy", "ros2", "plotjuggler", "openvins", "decimal commas", "ros1", "label", "w first in words"),
        *("units in brackets", "units in names", "dates", "dates and times"),
    ],
)
def test_tables_of_other_programs_are_their_path(head: str, line: str, tmp_path: Path) -> None:
    lines = [head, *(line.format(s=1_700_000_000, ms=f"{250 * i:03d}") for i in range(4))]
    (tmp_path / "poses.csv").write_text("\n".join(lines))
    found = read_poses(tmp_path / "poses.csv")
    np.testing.assert_allclose(found.time_s, [0, 0.25, 0.5, 0.75], atol=1e-6)
    np.testing.assert_allclose(found.poses[:, :3, 3], np.tile([1, 2, 3], (4, 1)))
    np.testing.assert_allclose(
        found.poses[2, :3, :3], Rotation.from_quat([0, 0.6, 0, 0.8]).as_matrix(), atol=1e-9
    )


@pytest.mark.parametrize(
    ("line", "w_first", "doubted"),
    [
        ("{s}.{ms},1,2,3,{q}", False, False),
        ("{s},{ms};1,0;2,0;3,0;{q}", False, False),
        ("{s}{ms}000000,1,2,3,{q}", True, True),
        ("{s}{ms}000000,1,2,3,{q},0,0,0", True, False),
    ],
)
def test_stamps_tell_where_w_is_in_tables_without_names(
    line: str, w_first: bool, doubted: bool, tmp_path: Path
) -> None:
    quaternion = [0.8, 0, 0.6, 0] if w_first else [0, 0.6, 0, 0.8]
    between = ";" if ";" in line else ","
    q = between.join(map(str, quaternion))
    file = tmp_path / "poses.csv"
    file.write_text("\n".join(line.format(s=1_700_000_000, ms=f"{250 * i:03d}", q=q) for i in range(1, 4)))
    found = read_poses(file)
    np.testing.assert_allclose(found.time_s, [0, 0.25, 0.5], atol=1e-6)
    np.testing.assert_allclose(Rotation.from_matrix(found.poses[0, :3, :3]).as_quat(), [0, 0.6, 0, 0.8])
    assert any("w is taken to be first" in doubt for doubt in found.doubts) == doubted


def test_a_comment_on_inverse_poses_is_doubted(tmp_path: Path) -> None:
    (tmp_path / "p.txt").write_text("# world-to-camera: time x y z qx qy qz qw\n0 1 2 3 0 0 0 1\n")
    _, doubts = read_recorded(tmp_path / "p.txt", np.eye(3), np.zeros(3), of_camera=False)
    assert any("world-to-camera" in doubt and "invert them" in doubt for doubt in doubts)


def test_a_pose_that_was_lost_is_named(tmp_path: Path) -> None:
    file = tmp_path / "p.txt"
    file.write_text("0 0 0 0 0 0 0 1\n1 nan nan nan 0 0 0 1\n")
    with pytest.raises(Unreadable, match="pose 2 holds numbers that are not finite"):
        read_poses(file)


def test_a_path_longer_than_a_day_is_refused_before_memory_is_taken(tmp_path: Path) -> None:
    with pytest.raises(Unreadable, match="give stamps in seconds"):
        read_poses(write_poses(tmp_path / "long.txt", ["0", "100", "200", "2e9"]))


@pytest.mark.parametrize(
    "form",
    ["ros", "nerf", "nerf out of order", "colmap", "colmap, no points", "matrices", "stamped matrices"],
)
@pytest.mark.parametrize("between", [" ", ","])
def test_one_path_in_the_forms_of_other_programs_is_one_path(form: str, between: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    turns, places = Rotation.random(5, rng=rng), rng.normal(size=(5, 3))
    matrices = np.tile(np.eye(4), (5, 1, 1))
    matrices[:, :3, :3], matrices[:, :3, 3] = turns.as_matrix(), places
    if form == "ros":
        position, rotation = ("field.pose.position.", "field.pose.orientation.")
        lines = ["%time,field.header.seq,field.header.stamp,field.header.frame_id,"]
        lines[0] += ",".join([position + axis for axis in "xyz"] + [rotation + axis for axis in "xyzw"])
        for i, (p, q) in enumerate(zip(places, turns.as_quat(), strict=True)):
            stamp = 1_700_000_000_000_000_000 + i * 100_000_000
            lines.append(",".join(map(str, [stamp + 7, i, stamp, "base link", *p, *q])))
        text = "\n".join(lines)
    elif form.startswith("nerf"):
        origin = np.array([4e5, -5e6, 2.0])
        near = [each - np.pad(origin[:, None], ((0, 1), (3, 0))) for each in matrices]
        frames = [{"transform_matrix": (each @ np.diag([1, -1, -1, 1])).tolist()} for each in near]
        if form == "nerf out of order":
            named = [{"file_path": f"r1/{9 + i}.png", **each} for i, each in enumerate(frames)]
            frames = [named[i] for i in (3, 0, 4, 1, 2)]
        text = json.dumps({"camera_angle_x": 0.7, "origin_m": origin.tolist(), "frames": frames})
    elif form.startswith("colmap"):
        lines = ["# Image list with two lines of data per image:"]
        for i, (turn, place) in enumerate(zip(turns, places, strict=True)):
            x, y, z, w = turn.inv().as_quat()
            at = -turn.inv().apply(place)
            pose = f"{i} {w} {x} {y} {z} {at[0]} {at[1]} {at[2]} 1 frame_{i}.jpg"
            lines[1:1] = [pose, "1.0 2.0 -1" * (i % 2)] if form == "colmap" else [pose]
        text = "\n".join(lines)
    else:
        stamps = [[0.1 * i] if form == "stamped matrices" else [] for i in range(5)]
        rows = [[*s, *each.ravel()] for s, each in zip(stamps, matrices, strict=True)]
        text = "\n".join(between.join(map(str, row)) for row in rows)
    file = tmp_path / "poses.txt"
    file.write_text(text)
    found = read_poses(file)
    np.testing.assert_allclose(found.poses, matrices, atol=1e-6)
    np.testing.assert_allclose(found.time_s, 0.1 * np.arange(5), atol=1e-6)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t,x,y,z,roll,pitch,yaw\n0,0,0,0,0,0,90\n", "give qx, qy, qz, qw"),
        ("0 1 2 3 0 0 90 0\n", "pose 1 .*no unit quaternion"),
        ("0 1 2 3 nan 0 0 1\n", "not finite"),
        ("0 1 2 3 0 0 0 1\n0 1 2 3 0 0 0 1\n", "do not rise"),
        ("0 1 2 3\n", "a line of names such as"),
        (
            "# in prose time x y z qx qy qz qw\n0 1 2 3 0 0 0 1\n",
            "line 2 has 8 numbers, its line of names more",
        ),
        ("1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 x 0 0 0 0 1 b.png\n", "where a pose belongs"),
        ('{"frames": [{"file_path": "a"}]}', "no transforms.json"),
    ],
)
def test_poses_that_could_be_taken_for_others_are_refused(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text(text)
    with pytest.raises(Unreadable, match=said):
        read_poses(tmp_path / "poses.csv")


def test_cameras_that_lie_on_their_side_are_doubted(tmp_path: Path) -> None:
    """As they do where w of a quaternion is taken for x, or axes for those of the other kind."""
    for order, doubted in (("xyzw", False), ("wxyz", True)):
        level = dict(zip("xyzw", Rotation.from_euler("xz", [-90, 30], degrees=True).as_quat(), strict=True))
        rows = [" ".join(map(str, [0.1 * i, i, 0, 1.6, *(level[part] for part in order)])) for i in range(9)]
        (tmp_path / "path.txt").write_text("\n".join(rows))
        _, doubts = read_recorded(tmp_path / "path.txt", np.eye(3), np.zeros(3), of_camera=True)
        assert any("on its side" in doubt for doubt in doubts) == doubted
