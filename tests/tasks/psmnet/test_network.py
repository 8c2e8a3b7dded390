"""PSMNet: the published names and wiring, and sizes the published code does not take."""

from __future__ import annotations

from ast import literal_eval
from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.learning.device import drawing_from  # noqa: E402
from tacos_plugins.tasks.psmnet.network import (  # noqa: E402
    PUBLISHED_PARAMETERS,
    PSMNet,
    cost_volume,
    soft_argmax,
)
from tests.tasks.psmnet.as_published import disparity_as_published  # noqa: E402

PUBLISHED = Path(__file__).with_name("published_entries.txt")


def published_entries() -> dict[str, tuple[int, ...]]:
    lines = [line for line in PUBLISHED.read_text().splitlines() if not line.startswith("#")]
    return {name: literal_eval(shape) for name, _, shape in (line.partition(" ") for line in lines)}


def narrow(max_disparity: int = 16, width: float = 0.1, **settings):
    with drawing_from(np.random.default_rng(4)):
        return PSMNet(max_disparity, width=width, **settings)


def images(count: int, height: int, width: int):
    rng = np.random.default_rng(5)
    return [torch.from_numpy(rng.normal(size=(count, 3, height, width)).astype(np.float32)) for _ in range(2)]


def test_entries_are_the_published_ones():
    network = PSMNet(192)
    assert {name: tuple(t.shape) for name, t in network.state_dict().items()} == published_entries()
    assert sum(parameter.numel() for parameter in network.parameters()) == PUBLISHED_PARAMETERS == 5_224_768


def test_the_forward_pass_is_the_published_one():
    network = narrow()
    with torch.no_grad():  # statistics and offsets that differ from layer to layer, as trained ones do
        for i, (name, tensor) in enumerate(network.state_dict().items()):
            if tensor.ndim == 1 and not name.endswith("num_batches_tracked"):
                tensor.add_(0.05 * torch.sin(torch.arange(len(tensor)) + i))
        left, right = images(1, 256, 320)
        (found,) = network.eval()(left, right)
        expected = disparity_as_published(network.state_dict(), left, right, max_disparity=16)
    assert expected.std() > 0.05, "the check needs an output that varies"
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-4)


def test_how_volumes_are_enlarged_can_be_chosen():
    left, right = images(1, 32, 32)
    with torch.no_grad():
        found = [narrow(align_corners=how).eval()(left, right)[0] for how in (True, False)]
    assert not torch.allclose(*found)


@pytest.mark.parametrize(("height", "width"), [(32, 32), (33, 47), (50, 200), (64, 96)])
def test_images_of_any_size(height, width):
    with torch.no_grad():
        (found,) = narrow().eval()(*images(2, height, width))
    assert found.shape == (2, height, width)
    assert (found >= 0).all()
    assert (found <= 15).all()


def test_more_disparities_than_columns():
    with torch.no_grad():
        (found,) = narrow(max_disparity=192).eval()(*images(1, 32, 32))
    assert found.shape == (1, 32, 32)


def test_training_gives_an_estimate_after_each_hourglass():
    network = narrow()
    left, right = images(2, 32, 64)
    assert len(network.train()(left, right)) == 3
    assert len(network.eval()(left, right)) == 1


def test_both_images_are_treated_alike():
    network = narrow().double().eval()
    left, right = (image.double() for image in images(1, 32, 64))
    with torch.no_grad():
        torch.testing.assert_close(
            network.feature_extraction(torch.cat([left, right]))[1:], network.feature_extraction(right)
        )


@pytest.mark.parametrize("max_disparity", [0, 8, 40])
def test_disparities_come_in_multiples_of_sixteen(max_disparity):
    with pytest.raises(ValueError, match=f"must be a multiple of 16, not {max_disparity}"):
        PSMNet(max_disparity)


def test_soft_argmax_against_numpy():
    volume = np.random.default_rng(6).normal(0, 3, (2, 12, 4, 5)).astype(np.float32)
    shares = np.exp(volume) / np.exp(volume).sum(1, keepdims=True)
    expected = (shares * np.arange(12)[None, :, None, None]).sum(1)
    np.testing.assert_allclose(soft_argmax(torch.from_numpy(volume)).numpy(), expected, rtol=1e-5)


def test_soft_argmax_of_one_sharp_peak_is_its_place():
    volume = torch.zeros(1, 20, 1, 1)
    volume[0, 13] = 100.0
    assert soft_argmax(volume).item() == pytest.approx(13)


def test_cost_volume_against_loops():
    rng = np.random.default_rng(7)
    left, right = (rng.normal(size=(2, 3, 4, 6)).astype(np.float32) for _ in range(2))
    expected = np.zeros((2, 6, 8, 4, 6), np.float32)
    for disparity in range(8):
        for x in range(disparity, 6):
            expected[:, :3, disparity, :, x] = left[..., x]
            expected[:, 3:, disparity, :, x] = right[..., x - disparity]
    found = cost_volume(torch.from_numpy(left), torch.from_numpy(right), 8)
    np.testing.assert_array_equal(found.numpy(), expected)


def test_in_half_precision_the_disparity_itself_is_not_halved():
    """As on a GPU, here on the CPU: convolutions in bfloat16, the mean over disparities not."""
    volume = torch.from_numpy(np.random.default_rng(8).normal(0, 2, (1, 1, 48, 4, 4)).astype(np.float32))
    network = narrow(max_disparity=192)
    plain = network._disparity(volume, (192, 16, 16))
    with torch.autocast("cpu", dtype=torch.bfloat16):
        assert torch.equal(network._disparity(volume, (192, 16, 16)), plain)
        with torch.no_grad():
            (found,) = network.eval()(*images(1, 32, 64))
    assert found.dtype == torch.float32
