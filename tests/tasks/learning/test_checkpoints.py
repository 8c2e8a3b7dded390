"""Weights from files: what is read, what is refused, and in what words."""

from __future__ import annotations

import os
import pickle

import numpy as np
import pytest

from tacos_framework.errors import UserError

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from safetensors.numpy import save_file as save_arrays  # noqa: E402
from safetensors.torch import save_file  # noqa: E402

from tacos_plugins.tasks.learning.checkpoints import (  # noqa: E402
    load_checkpoint,
    named_weights,
    read_checkpoint,
)
from tacos_plugins.tasks.learning.states import fresh_state  # noqa: E402


def network(width: int = 3):
    return torch.nn.Sequential(torch.nn.Linear(2, width), torch.nn.BatchNorm1d(width))


def tensors(**changes):
    return {**network().state_dict(), **changes}


@pytest.mark.parametrize("new_format", [True, False])
def test_checkpoints_of_parallel_training(tmp_path, new_format):
    path = tmp_path / "published.tar"
    weights = tensors()
    content = {"epoch": 300, "state_dict": {f"module.{k}": v for k, v in weights.items()}, "train_loss": 0.4}
    torch.save(content, path, _use_new_zipfile_serialization=new_format)
    read = read_checkpoint(path, where="weights")
    assert list(read) == list(weights)
    assert all(torch.equal(read[name], weights[name]) for name in weights)


def test_plain_dicts_and_safetensors(tmp_path):
    weights = tensors()
    torch.save(weights, tmp_path / "plain.pth")
    save_file(weights, tmp_path / "plain.safetensors")
    for path in sorted(tmp_path.iterdir()):
        read = read_checkpoint(path, where="weights")
        assert set(read) == set(weights)
        assert torch.equal(read["0.weight"], weights["0.weight"])


def test_states_of_our_own_results(tmp_path):
    weights = tensors()
    save_arrays(dict(fresh_state(weights, network())), tmp_path / "designed.task.3.safetensors")
    read = read_checkpoint(tmp_path / "designed.task.3.safetensors", where="weights")
    net = network()
    load_checkpoint(read, net, where="weights", made_for="a test network")
    assert torch.equal(net[0].weight, weights["0.weight"])


def test_counters_of_batch_normalisation_may_be_absent():
    weights = tensors()
    del weights["1.num_batches_tracked"]
    net = network()
    load_checkpoint(weights, net, where="weights", made_for="a test network")
    assert net[1].num_batches_tracked.item() == 0


class Bomb:
    def __reduce__(self):
        return os.mkdir, (os.environ["BOMB"],)


def test_code_in_a_checkpoint_is_never_run(tmp_path, monkeypatch):
    monkeypatch.setenv("BOMB", str(tmp_path / "went_off"))
    torch.save({"state_dict": tensors(), "extra": Bomb()}, tmp_path / "bomb.pth")
    (tmp_path / "bomb.pkl").write_bytes(pickle.dumps(Bomb()))
    for name in ("bomb.pth", "bomb.pkl"):
        with pytest.raises(UserError, match="more than tensors and plain values, which is not run"):
            read_checkpoint(tmp_path / name, where="weights")
    assert not (tmp_path / "went_off").exists()


def no_checkpoints(folder):
    (folder / "empty.pth").write_bytes(b"")
    (folder / "text.pth").write_text("weights\n")
    (folder / "text.safetensors").write_text("weights\n")
    (folder / "zip.pth").write_bytes(b"PK\x03\x04 cut short")
    torch.save(tensors(), folder / "cut.pth")
    whole = (folder / "cut.pth").read_bytes()
    (folder / "cut.pth").write_bytes(whole[: len(whole) // 2])
    torch.save([1, 2], folder / "list.pth")
    torch.save({}, folder / "nothing.pth")
    torch.save({"epoch": 3}, folder / "epoch.pth")
    return sorted(folder.iterdir())


def test_what_is_no_checkpoint_is_called_so(tmp_path):
    for path in no_checkpoints(tmp_path):
        with pytest.raises(UserError, match=f"{path.name} is not a checkpoint: ") as caught:
            read_checkpoint(path, where="task.test weights")
        (fault,) = caught.value.faults
        assert fault.where == "task.test weights", path.name
        assert "safetensors" in fault.expected


@pytest.mark.parametrize("content", [b"", b"<!DOCTYPE html>", b"garbage\n"])
@pytest.mark.parametrize("suffix", [".pth", ".safetensors"])
def test_what_begins_as_no_checkpoint_is_refused_before_anything_is_rendered(content, suffix, tmp_path):
    path = tmp_path / f"weights{suffix}"
    path.write_bytes(content)
    with pytest.raises(UserError, match="is not a checkpoint"):
        named_weights(str(path), where="weights")


def test_a_missing_file(tmp_path):
    with pytest.raises(UserError, match=r"there is no file .*absent\.pth"):
        read_checkpoint(tmp_path / "absent.pth", where="weights")


def test_another_architecture_is_told_apart_by_names_and_shapes():
    weights = tensors(**{"0.weight": torch.zeros(7, 2), "surplus.weight": torch.zeros(1)})
    del weights["1.bias"], weights["1.running_mean"]
    with pytest.raises(UserError) as caught:
        load_checkpoint(weights, network(), where="weights", made_for="a test network of width 3")
    (fault,) = caught.value.faults
    assert fault.what == (
        "the weights are not those of this architecture: 2 missing (1.bias, 1.running_mean); "
        "1 unknown (surplus.weight); 1 of another shape (0.weight (7, 2) instead of (3, 2))"
    )
    assert fault.expected == "the 7 entries of a test network of width 3"


def test_long_lists_of_names_are_cut():
    with pytest.raises(UserError, match=r"6 missing \(0.weight, 0.bias, 1.weight, and 3 more\)"):
        load_checkpoint({"x": torch.zeros(1)}, network(), where="weights", made_for="a test network")


def test_damaged_files_never_end_in_anything_but_a_sentence(tmp_path):
    torch.save(tensors(), tmp_path / "good.pth")
    save_file(tensors(), tmp_path / "good.safetensors")
    rng = np.random.default_rng(1)
    for good in sorted(tmp_path.iterdir()):
        for i in range(30):
            damaged = bytearray(good.read_bytes())
            damaged[rng.integers(min(len(damaged), 900))] = rng.integers(256)
            bad = tmp_path / f"{i}{good.suffix}"
            bad.write_bytes(damaged)
            try:
                read_checkpoint(bad, where="weights")
            except UserError:
                continue
