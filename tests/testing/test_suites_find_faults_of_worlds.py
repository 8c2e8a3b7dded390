"""Faults of scenes and renderers: in worlds, in light, in what is seen where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tacos_framework.settings import Settings
from tacos_framework.testing import RendererConformance, SceneConformance
from tacos_framework.testing.samples import sample_episode
from tacos_framework.values import Crossing
from tacos_plugins.renderers.analytic import AnalyticRenderer
from tests.testing.applied_suite import faults_are_found, sound_ones_pass


class SoundScene:
    """The sample episode, in a world that depends on the generator."""

    class Config(Settings):
        """No settings."""

    def __init__(self, config):
        pass

    def episode(self, *, rng, illumination_lux):
        episode = sample_episode(frames=4, brightness=illumination_lux / 20)
        return replace(episode, world=replace(episode.world, key=f"{rng.integers(2**32)} {illumination_lux}"))


class UnseededScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        return super().episode(rng=np.random.default_rng(), illumination_lux=illumination_lux)


class SameKeyScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        return replace(episode, world=replace(episode.world, key="always"))


class HeadstandScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        flipped = episode.trajectory.world_from_agent @ np.diag([1.0, -1.0, -1.0, 1.0])
        return replace(episode, trajectory=replace(episode.trajectory, world_from_agent=flipped))


class DarkLampScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        lights = tuple(replace(light, flux_lm=-light.flux_lm) for light in episode.world.lights)
        return replace(episode, world=replace(episode.world, lights=lights))


class BackgroundCrossingScene(SoundScene):
    def episode(self, *, rng, illumination_lux):
        episode = super().episode(rng=rng, illumination_lux=illumination_lux)
        return replace(episode, crossings=(Crossing(0, 0.1),))


class ChangedViews(AnalyticRenderer):
    """Hands on the views of a sound renderer, changed."""

    def capture(self, episode, *, rig, exposure):
        capture = super().capture(episode, rig=rig, exposure=exposure)
        return replace(capture, views=tuple(self.changed(view, exposure) for view in capture.views))

    def changed(self, view, exposure):
        return view


class RayLengthRenderer(ChangedViews):
    def changed(self, view, exposure):
        x = (np.arange(view.camera.width_px) - view.camera.centre_px[0]) / view.camera.focal_length_px
        return replace(view, depth_m=view.depth_m * np.hypot(1, x).astype(np.float32))


class GammaRenderer(ChangedViews):
    def changed(self, view, exposure):
        return replace(view, luminance_cd_m2=np.sqrt(view.luminance_cd_m2))


class ShiftedIdsRenderer(ChangedViews):
    def changed(self, view, exposure):
        return replace(view, object_id=np.roll(view.object_id, 9, axis=2))


class NoisyRenderer(ChangedViews):
    def changed(self, view, exposure):
        noise = np.random.default_rng().random(view.luminance_cd_m2.shape, np.float32)
        return replace(view, luminance_cd_m2=view.luminance_cd_m2 + noise)


class FadingRenderer(ChangedViews):
    """Counts frames from the beginning of the batch."""

    def changed(self, view, exposure):
        fading = 0.9 ** np.arange(len(view.depth_m), dtype=np.float32)
        return replace(view, luminance_cd_m2=view.luminance_cd_m2 * fading[:, None, None, None])


class SecretlyExposedRenderer(ChangedViews):
    def changed(self, view, exposure):
        return replace(view, luminance_cd_m2=view.luminance_cd_m2 * np.float32(exposure.gain))


FAULTS = [
    (SceneConformance, UnseededScene, "test_equal_generators_give_equal_episodes"),
    (SceneConformance, SameKeyScene, "test_other_generators_give_other_worlds_with_other_keys"),
    (SceneConformance, SameKeyScene, "test_other_light_is_another_world"),
    (SceneConformance, HeadstandScene, "test_its_poses_are_upright_and_rigid"),
    (SceneConformance, DarkLampScene, "test_its_light_is_light"),
    (SceneConformance, BackgroundCrossingScene, "test_its_crossings_name_objects_on_the_way"),
    (RendererConformance, RayLengthRenderer, "test_it_measures_depth_along_the_optical_axis"),
    (RendererConformance, GammaRenderer, "test_twice_the_light_gives_twice_the_luminance"),
    (RendererConformance, ShiftedIdsRenderer, "test_it_names_objects_where_they_are"),
    (RendererConformance, NoisyRenderer, "test_it_repeats_itself"),
    (RendererConformance, FadingRenderer, "test_batches_may_be_cut_anywhere"),
    (
        RendererConformance,
        SecretlyExposedRenderer,
        "test_the_light_of_a_scene_does_not_depend_on_how_it_is_exposed",
    ),
]
SOUND = [
    (SceneConformance, SoundScene),
    (RendererConformance, ChangedViews),
]


test_a_fault_is_found = faults_are_found(FAULTS)
test_sound_components_pass_what_the_faulty_ones_fail = sound_ones_pass(SOUND, FAULTS)
