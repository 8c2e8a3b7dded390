"""`scene.imported`, from files to trips."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tacos_framework.errors import UserError
from tacos_plugins.lighting import irradiance_at, photopic
from tacos_worlds.imported.labels import read_table
from tacos_worlds.imported.scene import ImportedScene
from tests.worlds.imported.two_rooms import ROOM_M, two_rooms


def scene(file: Path, **settings: object) -> ImportedScene:
    return ImportedScene(ImportedScene.Config(file=str(file), **{"frames": 12, **settings}))


@pytest.fixture(scope="module")
def imported(house: Path) -> ImportedScene:
    """The two rooms, read and lit once."""
    return scene(house)


def test_a_house_is_read_labelled_and_walked(imported: ImportedScene) -> None:
    place = imported.place
    assert {(o.name.split("/")[-1], o.class_name) for o in place.world.objects[1:]} == {
        ("door_sill", "threshold"),
        ("Sofa.001", "sofa"),
    }
    vertices = np.concatenate([part.vertices_m for part in place.world.parts])
    assert np.ptp(vertices, axis=0) == pytest.approx(
        [ROOM_M[0] + 0.2, ROOM_M[1] + 0.2, ROOM_M[2] + 0.2], abs=1e-4
    )
    points = place.floor.points_m
    assert points[:, 0].min() < 0.6
    assert points[:, 0].max() > 5.4
    on_sofa = np.all((points[:, :2] > [0.1, 0.1]) & (points[:, :2] < [1.9, 0.9]), axis=1)
    assert not on_sofa.any()
    episode = imported.episode(rng=np.random.default_rng(0), illumination_lux=30.0)
    eyes = episode.trajectory.at(episode.time_s)[:, :3, 3]
    assert len(episode) == 12
    assert np.all((eyes[:, :2] > 0) & (eyes[:, :2] < ROOM_M[:2]))
    assert np.all((eyes[:, 2] > 0.9) & (eyes[:, 2] < 2.1))


def test_the_same_seed_gives_the_same_trip_and_another_another(imported: ImportedScene) -> None:
    one, same, other = (
        imported.episode(rng=np.random.default_rng(seed), illumination_lux=30.0) for seed in (1, 1, 2)
    )
    assert np.array_equal(one.trajectory.world_from_agent, same.trajectory.world_from_agent)
    assert one.world.key == same.world.key == other.world.key
    assert not np.array_equal(one.trajectory.world_from_agent[:3], other.trajectory.world_from_agent[:3])


def test_light_comes_to_the_illuminance_asked_for(imported: ImportedScene) -> None:
    world = imported.episode(rng=np.random.default_rng(0), illumination_lux=80.0).world
    plane = imported.place.floor.points_m[::7] + np.array([0, 0, 1.0])
    up = np.tile(np.float32([0, 0, 1]), (len(plane), 1))
    assert photopic(irradiance_at(world, plane.astype(np.float32), up)).mean() == pytest.approx(
        80.0, rel=0.05
    )


def test_levels_scale_light_that_is_worked_out_once(
    imported: ImportedScene, house: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    day, dim = (
        imported.episode(rng=np.random.default_rng(0), illumination_lux=lux).world for lux in (500.0, 5.0)
    )
    assert day.unscaled is dim.unscaled is imported.place.world
    assert day.light_factor == pytest.approx(100 * dim.light_factor)
    assert day.key != dim.key != imported.place.world.key
    monkeypatch.setenv("TACOS_CACHE", str(tmp_path))
    monkeypatch.setattr("tacos_plugins.kept_worlds.store.WORTH_KEEPING_S", 0.0)
    first = scene(house).place
    monkeypatch.setattr("tacos_worlds.imported.place.LightTransport", None)  # nothing is traced
    kept = scene(house).place
    assert (
        (kept.lux, kept.world.key) == (first.lux, first.world.key) == (imported.place.lux, day.unscaled.key)
    )
    for one, other in zip(kept.world.indirect_lux, first.world.indirect_lux, strict=True):
        assert np.array_equal(one, other)


def test_thresholds_are_approached_at_the_times_asked_for(house: Path) -> None:
    imported = scene(house, sampling="approaches", before_step_s=(1.5, 0.5), frames=4)
    episode = imported.episode(rng=np.random.default_rng(3), illumination_lux=30.0)
    sill = next(i for i, o in enumerate(episode.world.objects) if o.class_name == "threshold")
    assert {crossing.object_id for crossing in episode.crossings} == {sill}
    first = episode.crossings[0]
    assert first.time_s - episode.time_s[:2] == pytest.approx([1.5, 0.5], abs=1e-6)
    under = episode.trajectory.at(np.array([first.time_s]))[0, :2, 3]
    assert 2.8 < under[0] < 3.2
    assert 1.5 < under[1] < 2.5


def test_a_table_of_labels_goes_before_names_and_tells_what_it_does_not_find(
    house: Path, tmp_path: Path
) -> None:
    table = tmp_path / "labels.csv"
    table.write_text("pattern,class\nthing *,crate\nsofa*,background\n", encoding="utf-8")
    names = {o.class_name for o in scene(house, labels=str(table)).place.world.objects}
    assert names == {"background", "crate", "threshold"}
    same = tmp_path / "labels.yaml"
    same.write_text('"thing *": crate\n"sofa*": background\n', encoding="utf-8")
    assert read_table(same) == read_table(table)
    tabs = tmp_path / "labels.tsv"
    tabs.write_text("Pattern\tClass\nthing *\tcrate\nsofa*\tbackground\n", encoding="utf-16")
    assert read_table(tabs) == read_table(table)
    table.write_text("pattern,class\nthang *,crate\nsofer*,sofa\n", encoding="utf-8")
    with pytest.raises(UserError) as caught:
        _ = scene(house, labels=str(table)).place
    assert len(caught.value.faults) == 2
    assert "matches no node" in str(caught.value)


@pytest.mark.parametrize("kind", ["ply", "obj"])
def test_a_mesh_without_names_normals_or_axes_is_a_world_too(kind: str, tmp_path: Path) -> None:
    # The walls of two rooms as one mesh, z up, in centimetres.
    mesh = two_rooms().to_mesh()
    mesh.apply_scale(100.0)
    file = tmp_path / f"scan.{kind}"
    trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(file)
    place = scene(file, metres_per_unit=0.01).place
    assert place.floor.points_m[:, 2] == pytest.approx(0.0, abs=0.03)
    assert 8.0 < place.floor.area_m2 < ROOM_M[0] * ROOM_M[1]
    normals = np.concatenate([part.normals for part in place.world.parts])
    assert np.abs(normals).max(axis=1) == pytest.approx(1.0)  # edges of boxes stay sharp


def test_colours_of_vertices_reach_the_picture(tmp_path: Path) -> None:
    room = trimesh.creation.box((5, 4, 2.6))
    for _ in range(3):
        room = room.subdivide()
    room.visual.vertex_colors = np.where(room.vertices[:, :1] > 0, [[200, 30, 30, 255]], [[30, 30, 200, 255]])
    file = tmp_path / "scan.ply"
    room.export(file)
    world = scene(file).place.world
    part = max(world.parts, key=lambda p: len(p.triangles))
    texture = world.materials[part.material].texture
    assert texture is not None
    centre = part.vertices_m[part.triangles].mean(axis=1)
    uv = part.uv_m[part.triangles].mean(axis=1)
    texel = texture[(uv[:, 1] * len(texture)).astype(int), (uv[:, 0] * len(texture)).astype(int)]
    red = centre[:, 0] > 0.7
    blue = centre[:, 0] < -0.7
    assert np.all(texel[red, 0] > texel[red, 2])
    assert np.all(texel[blue, 2] > texel[blue, 0])


def test_a_room_modelled_from_outside_is_turned_to_the_eye(tmp_path: Path) -> None:
    file = tmp_path / "box.ply"
    trimesh.creation.box((5, 4, 2.6)).export(file)
    part = scene(file).place.world.parts[0]
    centre = part.vertices_m[part.triangles].mean(axis=1)
    corners = part.vertices_m[part.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(np.einsum("ij,ij->i", normal, -centre) > 0)
    assert np.all(np.einsum("ij,ij->i", part.normals, part.vertices_m) < 0)


def test_far_surfaces_lose_their_triangles_first(tmp_path: Path) -> None:
    ground = trimesh.creation.box((4, 4, 0.1))
    near = trimesh.creation.icosphere(5, 0.5).apply_translation((1.2, 1.2, 0.6))
    far = trimesh.creation.icosphere(5, 0.5).apply_translation((60, 0, 0.6))
    file = tmp_path / "spheres.glb"
    meshes = {"ground": ground, "near": near, "far": far}
    y = trimesh.Scene(meshes)
    y.apply_transform(np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]))
    y.export(file)
    world = scene(file, triangles=12_000, ground="outside").place.world
    assert world.triangle_count < 14_000  # with the ground split for its light
    left = {"near": 0, "far": 0}
    for part in world.parts:
        if len(part.triangles) > 12:
            left["far" if part.vertices_m[:, 0].mean() > 30 else "near"] += len(part.triangles)
    assert left["near"] > 4 * left["far"] > 0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"file": "none.glb"}, "does not exist"),
        ({"file": "house.blend"}, "Export, glTF"),
        ({"file": "house.glb", "sky": "sky.jpg"}, "high dynamic range"),
    ],
)
def test_files_that_are_not_there_are_told_before_anything_is_read(
    settings: dict[str, str], said: str, house: Path, tmp_path: Path
) -> None:
    given = {
        key: str(house) if value == "house.glb" else str(tmp_path / value) for key, value in settings.items()
    }
    with pytest.raises(UserError, match=said):
        ImportedScene(ImportedScene.Config(**given))


def test_all_that_is_wrong_is_told_at_once(house: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.glb"
    cut.write_bytes(house.read_bytes()[:-500])
    poses = tmp_path / "poses.txt"
    poses.write_text("0 1 2\n", encoding="utf-8")
    with pytest.raises(UserError) as caught:
        _ = scene(house, leave_out=("nothing*",)).place
    assert "matches nothing" in str(caught.value)
    with pytest.raises(UserError, match="cut short"):
        _ = scene(cut).place
    with pytest.raises(UserError, match="TUM has 8"):
        _ = scene(house, path=str(poses)).place
    with pytest.raises(UserError, match="too small"):
        _ = scene(house, metres_per_unit=0.01).place
    with pytest.raises(UserError, match="nothing in the file is of the class"):
        scene(house, sampling="approaches", obstacles=("stair",)).episode(
            rng=np.random.default_rng(0), illumination_lux=1.0
        )


def test_obstacles_that_no_file_has_are_doubted_where_somebody_asked_for_them(house: Path) -> None:
    (doubt,) = scene(house, obstacles=("stair",)).remarks
    assert "nothing in the file is of the class stair (obstacles)" in doubt
    assert scene(house).remarks == scene(house, obstacles=("threshold",)).remarks == ()


def test_waypoints_are_walked_by_and_those_off_the_floor_refused(house: Path) -> None:
    way = ((1.0, 2.0), (5.0, 2.0))
    imported = scene(house, waypoints_m=way, frame_rate_hz=2.0)
    episode = imported.episode(rng=np.random.default_rng(0), illumination_lux=30.0)
    walked = episode.trajectory.world_from_agent[:, :2, 3]
    for place in way:
        assert np.linalg.norm(walked - place, axis=1).min() < 0.35
    off = scene(house, waypoints_m=((1.0, 2.0), (1.0, 0.5)))  # on the sofa
    with pytest.raises(UserError, match="waypoint 2 is"):
        off.episode(rng=np.random.default_rng(0), illumination_lux=30.0)


def test_a_recorded_path_steps_on_what_lies_below_it_under_a_ceiling(house: Path, tmp_path: Path) -> None:
    """A head 1.5 m above the floor walks through the door, from 1 m in x to 5 m, at 1 m/s."""
    poses = tmp_path / "poses.txt"
    poses.write_text("0 1 2 1.5 0 0 0 1\n4 5 2 1.5 0 0 0 1\n", encoding="utf-8")
    imported = scene(house, path=str(poses), path_of="agent", path_axes="world", frames=21)
    episode = imported.episode(rng=np.random.default_rng(0), illumination_lux=30.0)
    (crossing,) = episode.crossings
    assert episode.world.objects[crossing.object_id].class_name == "threshold"
    assert crossing.time_s == pytest.approx(1.9, abs=0.06)  # the sill begins at 2.9 m
