"""Image formation: effects act at their places, per camera, frame by frame, whoever asks."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.errors import CandidateFailed, UserError
from tacos_framework.formation import (
    EpisodeDraws,
    ImageFormation,
    PlacedControl,
    PlacedEffect,
    PlacedSensor,
)
from tacos_framework.settings import Settings, physical, setting
from tacos_framework.testing.samples import part_of, sample_capture, sample_exposure, sample_rig
from tacos_framework.values import ContextMissing
from tacos_plugins.controls.mean_level import MeanLevel
from tacos_plugins.sensors.affine_noise import AffineNoise

DRAWS = EpisodeDraws(7, ("design", 0))
SENSOR = PlacedSensor("sensor.affine-noise", "frames", AffineNoise(AffineNoise.Config()))


class Adding:
    """Adds a number of DN, or units of light; notes what it was given."""

    class Config(Settings):
        by: float = setting(0.0, help="How much.")

    stage: ClassVar[Any] = "readout"
    neutral: ClassVar[Mapping[str, Any]] = {"by": 0.0}

    def __init__(self, config: Config) -> None:
        self.config = config

    def on_array(self, samples, *, geometry, context, rng):
        return samples + np.float32(self.config.by) if self.config.by else samples


class AddingLight(Adding):
    stage: ClassVar[Any] = "optics"


class AddingToPixels(Adding):
    stage: ClassVar[Any] = "pixel"


class AddingToFiles(Adding):
    stage: ClassVar[Any] = "isp"


class Doubling(AddingToFiles):
    rank: ClassVar[int] = 9

    def on_array(self, samples, *, geometry, context, rng):
        return samples * np.float32(2)


class Drawing(Adding):
    """Draws, so that it shows which generator it is given."""

    def on_array(self, samples, *, geometry, context, rng):
        return samples + rng.standard_normal(samples.shape, dtype=np.float32) * np.float32(self.config.by)


class Counting(AddingLight):
    """Adds how many frames of the episode it has seen."""

    def on_array(self, samples, *, geometry, context, rng):
        context.memory["frames"] = context.memory.get("frames", 0) + 1
        return samples + np.float32(context.memory["frames"])


class EverySecond(AddingToFiles):
    """Adds a number of DN to every second frame, and leaves the others as they are."""

    def on_array(self, samples, *, geometry, context, rng):
        context.memory["frames"] = context.memory.get("frames", 0) + 1
        return samples if context.memory["frames"] % 2 else samples + np.float32(self.config.by)


class AddingElectrons(AddingToFiles):
    """Adds to files, by a number of DN or of electrons."""

    class Config(Settings):
        by: float = setting(0.0, help="How much.", unit="DN")
        by_e: float | None = physical("by", help="The same in electrons.", unit="e-")


class HalfADnPerElectron(AffineNoise):
    def dn_per_electron(self, camera, exposure):
        return 0.5


class Shifting:
    """Moves the image by whole pixels."""

    class Config(Settings):
        columns: float = setting(0.0, help="How far.", unit="1")

    stage: ClassVar[Any] = "optics"
    neutral: ClassVar[Mapping[str, Any]] = {"columns": 0.0}

    def __init__(self, config: Config) -> None:
        self.config = config

    def source(self, *, geometry, context, frames):
        if not self.config.columns:
            return None
        x, y = np.meshgrid(
            np.arange(geometry.width_px, dtype=float), np.arange(geometry.height_px, dtype=float)
        )
        return x - self.config.columns, y


class Needy(AddingToPixels):
    def on_array(self, samples, *, geometry, context, rng):
        raise ContextMissing("effect.needy needs the velocity of the capture")


class NeedyOfLight(Needy):
    stage: ClassVar[Any] = "optics"


class NeedyOfFiles(Needy):
    stage: ClassVar[Any] = "isp"


def placed(
    cls: type[Any], name: str = "", cameras: tuple[str, ...] | None = None, **config: Any
) -> PlacedEffect:
    return PlacedEffect(
        f"effect.{name or cls.__name__.lower()}",
        name or cls.__name__,
        cls,
        cls.Config(**config),
        cameras=cameras,
    )


def expose(*effects: PlacedEffect, frames: int = 2, draws: EpisodeDraws = DRAWS, rig=None):
    formation = ImageFormation(sample_exposure(), effects)
    capture = formation.light(sample_capture(rig, frames), draws)
    return formation.expose(capture, SENSOR, draws)


def test_effects_act_in_the_order_of_image_formation_whatever_the_order_of_the_list() -> None:
    effects = [placed(Doubling), placed(AddingToFiles, by=5.0), placed(Adding, by=20.0)]
    plain = expose().images[0].astype(float)
    for chosen in (effects, effects[::-1]):
        found = expose(*chosen).images[0].astype(float)
        np.testing.assert_allclose(found, np.clip(2 * (np.clip(plain + 20, 0, 255) + 5), 0, 255), atol=1)


def test_an_effect_acts_on_the_cameras_it_is_placed_at_with_their_own_settings() -> None:
    rig = sample_rig("left", "right", "third")
    plain = expose(rig=rig)
    effect = placed(AddingToFiles, by=10.0, cameras=("left", "right"))
    effect = replace(effect, by_camera={"right": AddingToFiles.Config(by=20.0)})
    found = expose(effect, rig=rig)
    for camera, by in enumerate((10, 20, 0)):
        expected = np.clip(plain.images[camera].astype(int) + by, 0, 255)
        np.testing.assert_array_equal(found.images[camera], expected)


def test_an_effect_inside_the_sensor_may_stand_before_it_in_the_graph() -> None:
    """It waits at the capture, and does what it does in the list of a recipe."""
    formation = ImageFormation(sample_exposure())
    capture = sample_capture()
    for cls in (Adding, AddingToPixels, Drawing):
        effect = placed(cls, by=3.0)
        waiting = formation.with_effect(capture, effect, DRAWS)
        assert waiting.pending == (effect,)
        found = formation.expose(waiting, SENSOR, DRAWS)
        assert found.capture.pending == ()
        listed = ImageFormation(sample_exposure(), [effect]).expose(capture, SENSOR, DRAWS)
        np.testing.assert_array_equal(found.images[0], listed.images[0])


def test_effects_on_light_and_files_act_as_nodes_at_once() -> None:
    formation = ImageFormation(sample_exposure())
    capture = sample_capture()
    brighter = formation.with_effect(capture, placed(AddingLight, by=1.0), DRAWS)
    np.testing.assert_array_equal(
        brighter.views[0].luminance_cd_m2, capture.views[0].luminance_cd_m2 + np.float32(1)
    )
    assert np.shares_memory(brighter.views[0].depth_m, capture.views[0].depth_m)
    frames = formation.expose(capture, SENSOR, DRAWS)
    assert formation.with_effect(frames, placed(AddingToFiles), DRAWS) is frames
    with pytest.raises(TypeError, match="of the stage readout acts before there are frames"):
        formation.with_effect(frames, placed(Adding, by=1.0), DRAWS)


def test_an_effect_on_files_that_leaves_some_frames_alone_acts_on_the_others() -> None:
    """As a node of the graph it does what it does in the list of a recipe."""
    effect = placed(EverySecond, by=20.0)
    listed = expose(effect, frames=5, draws=EpisodeDraws(7, ("design", 0)))
    formation, draws = ImageFormation(sample_exposure()), EpisodeDraws(7, ("design", 0))
    found = formation.with_effect(formation.expose(sample_capture(frames=5), SENSOR, draws), effect, draws)
    np.testing.assert_array_equal(found.images[0], listed.images[0])


def test_electrons_in_files_are_those_of_the_sensor_that_took_them() -> None:
    """As a node of the graph the effect does what it does in the list of a recipe, camera by camera."""
    rig, effect = sample_rig("left", "right"), placed(AddingElectrons, by_e=200.0)
    sensor = replace(SENSOR, by_camera={"right": HalfADnPerElectron(AffineNoise.Config())})
    draws = EpisodeDraws(7, ("design", 0))
    listed = ImageFormation(sample_exposure(), [effect]).expose(sample_capture(rig), sensor, draws)
    formation = ImageFormation(sample_exposure())
    plain = formation.expose(sample_capture(rig), sensor, draws)
    found = formation.with_effect(plain, effect, draws)
    for image, same, before in zip(found.images, listed.images, plain.images, strict=True):
        assert not np.array_equal(image, before)
        np.testing.assert_array_equal(image, same)
    with pytest.raises(CandidateFailed, match="how many DN an electron makes on camera 'left' is not known"):
        formation.with_effect(replace(plain, dn_per_electron=()), effect, draws)


def test_where_pixels_move_truth_moves_along() -> None:
    capture = sample_capture()
    moved = ImageFormation(sample_exposure(), [placed(Shifting, columns=8.0)]).light(capture, DRAWS)
    before, after = capture.views[0], moved.views[0]
    np.testing.assert_array_equal(after.object_id[:, :, 8:], before.object_id[:, :, :-8])
    np.testing.assert_allclose(
        after.luminance_cd_m2[:, :, 9:-1], before.luminance_cd_m2[:, :, 1:-9], rtol=1e-5
    )
    assert ImageFormation(sample_exposure(), [placed(Shifting)]).light(capture, DRAWS) is capture


@settings(max_examples=20, deadline=None)
@given(cuts=st.sets(st.integers(1, 5)))
def test_frames_do_not_depend_on_how_an_episode_is_cut(cuts: set[int]) -> None:
    effects = [placed(Drawing, by=4.0), placed(Counting)]
    whole = expose(*effects, frames=6, draws=EpisodeDraws(7, ("design", 0))).images[0]
    formation = ImageFormation(sample_exposure(), effects)
    capture, draws = sample_capture(frames=6), EpisodeDraws(7, ("design", 0))
    edges = [0, *sorted(cuts), 6]
    parts = [part_of(capture, a, b) for a, b in itertools.pairwise(edges)]
    files = [formation.expose(formation.light(part, draws), SENSOR, draws).images[0] for part in parts]
    np.testing.assert_array_equal(np.concatenate(files), whole)


@pytest.mark.parametrize(
    "control", [None, PlacedControl("control.mean-level", MeanLevel(MeanLevel.Config()))]
)
def test_cameras_whose_files_differ_in_range_are_refused(control: PlacedControl | None) -> None:
    """Frames have one black level and one white level: a second one would be lost without a word."""
    deeper = AffineNoise(AffineNoise.Config(bit_depth=12))
    sensor = replace(SENSOR, by_camera={"right": deeper})
    formation, capture = (
        ImageFormation(sample_exposure(), (), control),
        sample_capture(sample_rig("left", "right")),
    )
    with pytest.raises(UserError) as refused:
        formation.expose(capture, sensor, EpisodeDraws(7, ("design", 0)))
    said = str(refused.value)
    assert "node 'frames', camera 'right': files of 0 .. 4095 DN" in said
    assert "0 .. 255 DN, as those of camera 'left'" in said
    noisier = AffineNoise(AffineNoise.Config(responsivity_dn_per_lux_s=1.0))
    sensor = replace(SENSOR, by_camera={"right": noisier})
    assert formation.expose(capture, sensor, EpisodeDraws(7, ("design", 0))).white_level_dn == 255


def test_frames_episodes_cameras_and_effects_draw_apart() -> None:
    rig = sample_rig("left", "right")
    grey = replace(sample_capture(rig, 2), views=tuple(_even(v) for v in sample_capture(rig, 2).views))
    formation = ImageFormation(sample_exposure())

    def noise(draws: EpisodeDraws, name: str) -> list[np.ndarray]:
        waiting = formation.with_effect(grey, placed(Drawing, name, by=8.0), draws)
        return [image.astype(int) for image in formation.expose(waiting, SENSOR, draws).images]

    first = noise(DRAWS, "a")
    others = [noise(EpisodeDraws(7, ("design", 1)), "a"), noise(EpisodeDraws(8, ("design", 0)), "a")]
    assert not np.array_equal(first[0], first[1])
    assert not np.array_equal(first[0][0], first[0][1])
    for other in (*others, noise(DRAWS, "b")):
        assert not np.array_equal(first[0], other[0])
    np.testing.assert_array_equal(first[0], noise(EpisodeDraws(7, ("design", 0)), "a")[0])


def _even(view):
    return replace(view, luminance_cd_m2=np.full_like(view.luminance_cd_m2, 3.0))


def test_what_an_effect_lacks_is_said_to_the_user() -> None:
    with pytest.raises(
        UserError, match=r"camera 'camera': effect.needy needs the velocity(.|\n)*to do: Use a sensor"
    ):
        expose(placed(Needy))


@pytest.mark.parametrize("needy", [Needy, NeedyOfLight, NeedyOfFiles])
def test_what_an_effect_lacks_is_said_of_the_camera_that_lacks_it(needy: type[Needy]) -> None:
    with pytest.raises(UserError, match=r"camera 'right': effect\.needy needs the velocity"):
        expose(placed(needy, cameras=("right",)), rig=sample_rig("left", "right"))


def test_an_error_of_an_effect_says_whose_it_is() -> None:
    class Broken(Adding):
        def on_array(self, samples, *, geometry, context, rng):
            raise ZeroDivisionError("nothing")

    with pytest.raises(ZeroDivisionError) as caught:
        expose(placed(Broken, "broken"))
    assert any("effect.broken" in note for note in caught.value.__notes__)
