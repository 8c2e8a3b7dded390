"""Pictures of two devices: what counts as a difference, and that software agrees with itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.cli import run_main
from tacos_framework.errors import UserError
from tacos_plugins.chosen_device import chosen_device
from tacos_plugins.renderers.moderngl.context import _LIBRARIES
from tacos_plugins.renderers.moderngl.egl_devices import cuda_numbers
from tacos_validation.gpu_checked.pictures import Pictures, difference


@pytest.fixture
def pictures() -> Pictures:
    depth = np.full((2, 4, 5), 2.0, np.float32)
    depth[:, 0] = np.inf
    light = np.ones((2, 4, 5, 3), np.float32)
    return Pictures("a", True, light, depth, np.ones((2, 4, 5), np.int32), 10.0)


def test_equal_pictures_do_not_differ(pictures) -> None:
    found = difference(pictures, replace(pictures, renderer="b"))
    assert (found.ids, found.depth, found.luminance) == (0, 0, 0)


def test_each_share_counts_its_own_pixels(pictures) -> None:
    ids, depth, light = (
        array.copy() for array in (pictures.object_id, pictures.depth_m, pictures.luminance_cd_m2)
    )
    ids[0, 1, 0] = 7
    depth[0, 1, 0] = 9.0  # of another thing: the id says so already
    depth[0, 1, 1] = 2.1
    depth[1, 0, 0] = 5.0  # where nothing was
    light[0, 2, :2, 1] = 1.5
    light[0, 3, 0] = 1.01  # within the tolerance
    found = difference(pictures, replace(pictures, object_id=ids, depth_m=depth, luminance_cd_m2=light))
    assert found.ids == pytest.approx(1 / 40)
    assert found.depth == pytest.approx(2 / 40)
    assert found.luminance == pytest.approx(2 / 40)


@pytest.mark.parametrize(
    ("given", "chosen"), [("", None), ("auto", None), ("cpu", "cpu"), ("1", 1), ("cuda:2", 2)]
)
def test_a_device_is_chosen_for_all(monkeypatch, given: str, chosen: object) -> None:
    monkeypatch.setenv("TACOS_DEVICE", given)
    assert chosen_device() == chosen


def test_nonsense_is_refused(monkeypatch, capsys) -> None:
    monkeypatch.setenv("TACOS_DEVICE", "gpu")
    with pytest.raises(UserError, match="'gpu' is no device"):
        chosen_device()
    with pytest.raises(SystemExit) as end:
        run_main(["headset_quick", "--device", "gpu"])
    assert end.value.code == 2
    assert "'gpu' is neither cpu nor the number of a GPU" in capsys.readouterr().err


def test_devices_of_egl_are_listed() -> None:
    found = cuda_numbers(_LIBRARIES[0][1])
    assert all(number is None or number >= 0 for number in found)
    assert len(set(found) - {None}) == len([number for number in found if number is not None])
