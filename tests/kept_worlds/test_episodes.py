"""Studies see the same worlds with and without the store, and other worlds where anything differs."""

from __future__ import annotations

import importlib
import sys

import numpy as np
import pytest
from toy_study import toy_recipe

from tacos_framework.plan import make_plan
from tacos_framework.settings import Settings, setting
from tacos_framework.simulation import EpisodeSpec, Simulation
from tacos_framework.values import Camera, Episode, Exposure, Rig
from tacos_plugins.kept_worlds import store as store_module
from tacos_plugins.kept_worlds.episodes import StoredEpisodes
from tacos_plugins.kept_worlds.fingerprints import code_key, settings_key
from tacos_plugins.kept_worlds.store import FOLDER_VARIABLE, WorldStore
from tacos_plugins.kept_worlds.structures import taken_apart
from tacos_worlds.indoor.scene import IndoorScene

VALUES = {"focal_length_mm": 1.0, "pitch_deg": 0.0}


@pytest.fixture
def kept(tmp_path, monkeypatch) -> WorldStore:
    monkeypatch.setattr(store_module, "WORTH_KEEPING_S", 0.0)
    return WorldStore(tmp_path / "kept")


def key_of_world(simulation: Simulation, spec: EpisodeSpec) -> str:
    (batch, *_) = simulation.batches("width", VALUES, spec)
    return batch.episode.world.key


def test_another_simulation_sees_the_same_world_and_another_seed_name_light_or_setting_another(
    toys, kept
) -> None:
    def simulation(**changes) -> Simulation:
        return Simulation(make_plan(toy_recipe(**changes), toys), StoredEpisodes(kept))

    spec = EpisodeSpec(3, ("design", 0, 0))
    alone = key_of_world(Simulation(make_plan(toy_recipe(), toys)), spec)
    assert [key_of_world(simulation(), spec) for _ in range(2)] == [alone, alone]
    assert kept.contents().entries == 1
    others = [
        (simulation(), EpisodeSpec(4, ("design", 0, 0))),
        (simulation(), EpisodeSpec(3, ("design", 0, 1))),
        (simulation(), EpisodeSpec(3, ("design", 0, 0), frames=5)),
        (simulation(scenario={"illumination_lux": 21.0}), spec),
    ]
    for number, (other, its) in enumerate(others):
        key_of_world(other, its)
        assert kept.contents().entries == number + 2


def test_what_is_kept_of_a_house_is_the_house(kept) -> None:
    from tacos_plugins.kept_worlds.episodes import CLASSES

    config = IndoorScene.Config(size_m=(4, 4), min_room_m=3.5, frames=4, clutter=0)

    def make() -> Episode:
        return IndoorScene(config).episode(rng=np.random.default_rng(1), illumination_lux=20.0)

    built = StoredEpisodes(kept).episode(IndoorScene, config, {"seed": 1}, make)
    read = StoredEpisodes(kept).episode(IndoorScene, config, {"seed": 1}, lambda: pytest.fail("made twice"))
    one, other = taken_apart(built, CLASSES), taken_apart(read, CLASSES)
    assert one[0] == other[0]
    assert all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in zip(one[1], other[1], strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["indoor", "street"])
def test_frames_are_the_same_bits_with_and_without_the_store(tmp_path, monkeypatch, scene: str) -> None:
    from tacos_plugins.renderers.moderngl.context import gl_context
    from tacos_plugins.renderers.moderngl.device import Device

    if scene == "indoor":
        config = IndoorScene.Config(size_m=(8, 5), min_room_m=4, frames=2)
        cls = IndoorScene
    else:
        from tacos_worlds.street.scene import StreetScene as cls

        config = cls.Config(blocks=1, texture_px=64, frames=2)
    monkeypatch.setattr(store_module, "WORTH_KEEPING_S", 0.0)
    rig = Rig((Camera("a", 160, 120, pixel_um=3.0, focal_length_mm=0.4),))
    frames = []
    for folder in ("off", str(tmp_path), str(tmp_path)):
        monkeypatch.setenv(FOLDER_VARIABLE, folder)

        def make() -> Episode:
            return cls(config).episode(rng=np.random.default_rng(1), illumination_lux=200.0)

        episode = (
            make()
            if folder == "off"
            else StoredEpisodes(WorldStore(tmp_path)).episode(cls, config, {"seed": 1}, make)
        )
        painter = Device(gl_context()).painter(episode.world, 0.2)
        frames.append(_frames(painter, episode, rig))
    for again in frames[1:]:
        for one, other in zip(frames[0], again, strict=True):
            assert np.array_equal(one, other)


def _frames(painter, episode: Episode, rig: Rig) -> list[np.ndarray]:
    from tacos_plugins.renderers.moderngl import renderer

    component = renderer.ModernglRenderer(renderer.ModernglRenderer.Config(light_texel_m=0.2))
    device = renderer.device()
    device.painters._held[episode.world.key, 0.2] = painter  # lit by the device under test
    (view,) = component.capture(episode, rig=rig, exposure=Exposure(0.01, 2.0, 0.0)).views
    del device.painters._held[episode.world.key, 0.2]
    return [view.luminance_cd_m2, view.depth_m, view.object_id]


def test_other_code_is_another_key(tmp_path, monkeypatch) -> None:
    package = tmp_path / "some_scenes"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "scene.py").write_text("class Scene:\n    size = 1\n")
    (package / "table.csv").write_text("1\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    try:
        scene = importlib.import_module("some_scenes.scene").Scene
        keys = [code_key(scene)]
        (package / "scene.py").write_text("class Scene:\n    size = 22\n")
        keys.append(code_key(scene))
        (package / "table.csv").write_text("11\n")
        keys.append(code_key(scene))
    finally:
        for name in ("some_scenes", "some_scenes.scene"):
            sys.modules.pop(name, None)
    assert len(set(keys)) == 3
    assert code_key(type("Local", (), {"__module__": "__main__"})) is None


def test_files_that_settings_name_count_by_their_content(tmp_path) -> None:
    class Config(Settings):
        folder: str = setting("", help="A folder.", is_path=True)

    keys = {settings_key(Config())}
    config = Config(folder=str(tmp_path))
    keys.add(settings_key(config))
    (tmp_path / "chair.glb").write_text("a")
    keys.add(settings_key(config))
    (tmp_path / "chair.glb").write_text("bb")
    keys.add(settings_key(config))
    assert len(keys) == 4
