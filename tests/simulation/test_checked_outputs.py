"""Light that is not finite, depth that is no number: refused in a sentence that names who gave it."""

from __future__ import annotations

import numpy as np
import pytest

from tacos_framework.errors import ContractBroken
from tacos_framework.formation.checked import checked_samples
from tacos_framework.simulation.checked_outputs import checked_output, checked_scores
from tacos_framework.values import Camera, Capture, Episode, FrameBatch, Object, Trajectory, View, World

CAMERA = Camera("left", width_px=4, height_px=3, focal_length_mm=2.0, pixel_um=3.0)
NAME = "renderer.acme of acme-worlds"


def capture(light=1.0, depth=2.0, at=None) -> Capture:
    """Two frames of one camera, even but for the value of one pixel."""
    lights, depths = np.full((2, 3, 4, 3), 1.0), np.full((2, 3, 4), 2.0)
    lights[(*at, 1) if at else ...] = light
    depths[at if at else ...] = depth
    poses = np.tile(np.eye(4), (2, 1, 1))
    world = World("w", (), (), (Object("background", "background"),), ("background",), np.ones(3, np.float32))
    episode = Episode(
        world, Trajectory(np.zeros(1), np.eye(4)[None]), np.arange(2) / 10, np.zeros(2, np.int32)
    )
    return Capture(episode, (View(CAMERA, poses, lights, depths, np.zeros((2, 3, 4), np.int32)),))


@pytest.mark.parametrize("depth", [2.0, np.inf])
def test_sound_captures_and_frames_pass_as_they_are(depth):
    sound = capture(depth=depth)
    assert checked_output(NAME, sound) is sound
    frames = FrameBatch(sound, (np.zeros((2, 3, 4, 1), np.uint8),))
    assert checked_output(NAME, frames) is frames


@pytest.mark.parametrize(("light", "shown"), [(np.nan, "nan"), (np.inf, "inf"), (-np.inf, "-inf")])
def test_light_must_be_finite(light, shown):
    with pytest.raises(ContractBroken) as raised:
        checked_output(NAME, capture(light=light, at=(1, 2, 3)))
    assert str(raised.value) == (
        f"{NAME} gives {shown} as light of camera 'left' in 1 of 72 values, "
        "the first at frame 1, row 2, column 3, channel 1"
    )


@pytest.mark.parametrize(("depth", "shown"), [(np.nan, "nan"), (-np.inf, "-inf")])
def test_depth_must_be_a_number(depth, shown):
    with pytest.raises(ContractBroken) as raised:
        checked_output(NAME, capture(depth=depth, at=(0, 1, 2)))
    assert str(raised.value) == (
        f"{NAME} gives {shown} as depth of camera 'left' in 1 of 24 values, "
        "the first at frame 0, row 1, column 2"
    )


def test_infinities_that_cancel_each_other_are_found_without_a_warning():
    lights = np.array([[[np.inf, -np.inf, 1.0]]])
    with pytest.raises(
        ContractBroken, match="gives inf as values in 2 of 3 values, the first at frame 0, row 0, column 0"
    ):
        checked_output(NAME, lights)


def test_bright_light_whose_sum_overflows_passes():
    bright = np.full(1000, 3e38, np.float32)
    assert checked_output(NAME, bright) is bright


def test_nothing_at_all_is_refused():
    with pytest.raises(ContractBroken, match=f"{NAME} gives nothing"):
        checked_output(NAME, None)


def test_values_of_plugins_own_types_pass():
    mine = object()
    assert checked_output(NAME, mine) is mine


@pytest.mark.parametrize("inside", [[np.array([np.nan])], {"flow": np.array([np.nan])}])
def test_arrays_inside_lists_and_mappings_are_looked_at(inside):
    with pytest.raises(ContractBroken, match=r"gives nan as values in 1 of 1 values, the first at index"):
        checked_output(NAME, inside)


def test_samples_keep_their_shape():
    like = np.zeros((1, 3, 4, 3), np.float32)
    mono = np.zeros((1, 3, 4, 1), np.float32)
    assert checked_samples(NAME, mono, like) is mono
    with pytest.raises(ContractBroken, match=r"an array of the shape \(3, 4, 3\) for one of \(1, 3, 4, 3\)"):
        checked_samples(NAME, like[0], like)
    with pytest.raises(ContractBroken, match="gives a list where an array is expected"):
        checked_samples(NAME, [1.0], like)
    with pytest.raises(ContractBroken, match="gives nan as samples in 36 of 36"):
        checked_samples(NAME, like * np.nan, like)
    nowhere = like * np.nan
    assert checked_samples(NAME, nowhere, nowhere) is nowhere


@pytest.mark.parametrize("value", [1, 0.5, np.float32(0.5), np.int64(3), np.array(0.5), True])
def test_scores_are_numbers_by_name(value):
    assert checked_scores(NAME, {"seen": value}) == {"seen": float(value)}


@pytest.mark.parametrize(
    ("scores", "said"),
    [
        ({"seen": float("nan")}, "reports nan as its score 'seen'"),
        ({"seen": np.float32(np.inf)}, "reports inf as its score 'seen'"),
        ({"seen": "many"}, "reports 'many' as its score 'seen', not a number"),
        ({"seen": None}, "reports None as its score 'seen', not a number"),
        ({"seen": np.array([1.0])}, "as its score 'seen', not a number"),
        (0.5, "reports 0.5 where scores by name are expected"),
    ],
)
def test_other_scores_are_refused(scores, said):
    with pytest.raises(ContractBroken, match=r"^renderer\.acme of acme-worlds reports") as raised:
        checked_scores(NAME, scores)
    assert said in str(raised.value)
