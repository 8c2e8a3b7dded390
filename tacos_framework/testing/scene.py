"""Conformance suite of scenes."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.testing.call import supplied
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.values import Episode


class SceneConformance(ComponentConformance):
    """The suite for scenes; choose settings that make small ones."""

    kind: ClassVar[str] = "scene"
    illumination_lux: ClassVar[float] = 20.0

    def generate(self, seed: int = 1, **changes: Any) -> Episode:
        """An episode by a new instance of the scene."""
        scene = self.make()
        offered = {"rng": np.random.default_rng(seed), "illumination_lux": self.illumination_lux, **changes}
        episode = scene.episode(**supplied(scene.episode, **offered))
        assert isinstance(episode, Episode)
        return episode

    @pytest.fixture(scope="class")
    @classmethod
    def episode(cls) -> Episode:
        """The episode most tests look at."""
        return cls().generate()

    def test_equal_generators_give_equal_episodes(self, episode: Episode) -> None:
        assert fingerprint(self.generate()) == fingerprint(episode)

    def test_other_generators_give_other_worlds_with_other_keys(self, episode: Episode) -> None:
        if not supplied(self.component.episode, rng=None):
            pytest.skip("the scene asks for no generator: its settings say all")
        other = self.generate(seed=2)
        assert fingerprint(other.world) != fingerprint(episode.world)
        assert other.world.key != episode.world.key

    def test_other_light_is_another_world(self, episode: Episode) -> None:
        brighter = self.generate(illumination_lux=2 * self.illumination_lux)
        if fingerprint(brighter.world.lights) != fingerprint(episode.world.lights):
            assert brighter.world.key != episode.world.key

    def test_its_frames_lie_on_the_path_in_order(self, episode: Episode) -> None:
        assert len(episode) > 0
        assert np.all(np.diff(episode.time_s) > 0), "frame times must rise"
        assert episode.trajectory.time_s[0] <= episode.time_s[0]
        assert episode.time_s[-1] <= episode.trajectory.time_s[-1]
        changes = np.count_nonzero(np.diff(episode.walk))
        assert changes + 1 == len(np.unique(episode.walk)), "the frames of a walk must be consecutive"

    def test_its_poses_are_upright_and_rigid(self, episode: Episode) -> None:
        poses = episode.trajectory.at(episode.time_s)
        rotation = poses[:, :3, :3]
        np.testing.assert_allclose(rotation @ rotation.swapaxes(1, 2) - np.eye(3), 0, atol=1e-6)
        assert np.all(np.linalg.det(rotation) > 0)
        assert np.all(rotation[:, 2, 2] > 0), "the agent stands on its head"

    def test_its_meshes_are_sound(self, episode: Episode) -> None:
        assert episode.world.triangle_count > 0
        for part in episode.world.parts:
            assert np.isfinite(part.vertices_m).all()
            assert np.isfinite(part.uv_m).all()
            np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1.0, atol=1e-3)
            assert part.triangles.min(initial=0) >= 0
            assert part.triangles.max(initial=0) < max(len(part.vertices_m), 1)

    def test_its_light_is_light(self, episode: Episode) -> None:
        world = episode.world
        assert np.isfinite(world.ambient_cd_m2).all()
        assert (world.ambient_cd_m2 >= 0).all()
        for light in world.lights:
            assert np.isfinite(light.flux_lm).all()
            assert (light.flux_lm >= 0).all()

    def test_its_crossings_name_objects_on_the_way(self, episode: Episode) -> None:
        for crossing in episode.crossings:
            assert 0 < crossing.object_id < len(episode.world.objects)
            assert episode.trajectory.time_s[0] <= crossing.time_s <= episode.trajectory.time_s[-1]
            assert crossing.walk is None or crossing.walk in episode.walk, (
                "a crossing of a walk without frames"
            )
