"""States of modules and their optimizers: nothing is lost on the way through arrays."""

from __future__ import annotations

import numpy as np
import pytest
from safetensors.numpy import load, save

from tacos_framework.testing.fingerprint import fingerprint

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.learning.device import drawing_from  # noqa: E402
from tacos_plugins.tasks.learning.states import fresh_state, restore, state_of  # noqa: E402


def network():
    with drawing_from(np.random.default_rng(3)):
        net = torch.nn.Sequential(
            torch.nn.Linear(4, 5), torch.nn.BatchNorm1d(5), torch.nn.ReLU(), torch.nn.Linear(5, 1)
        )
    net[0].weight.requires_grad_(False)
    return net


def adam_of(net):
    return torch.optim.Adam([p for p in net.parameters() if p.requires_grad], lr=0.01)


def step(net, adam, seed: int) -> None:
    batch = torch.from_numpy(np.random.default_rng(seed).normal(size=(8, 4)).astype(np.float32))
    adam.zero_grad()
    net(batch).square().mean().backward()
    adam.step()


def trained(steps: int):
    net = network()
    adam = adam_of(net)
    for seed in range(steps):
        step(net, adam, seed)
    return net, adam


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_going_on_from_a_state_equals_never_having_stopped(steps):
    unbroken, unbroken_adam = trained(steps)
    state = load(save(dict(state_of(unbroken, unbroken_adam, schedule_steps=steps))))
    resumed = network()
    resumed_adam = adam_of(resumed)
    assert restore(state, resumed, resumed_adam) == steps
    for net, adam in ((unbroken, unbroken_adam), (resumed, resumed_adam)):
        step(net, adam, seed=99)
    assert fingerprint(state_of(resumed, resumed_adam)) == fingerprint(state_of(unbroken, unbroken_adam))


def test_names_and_shapes_stay_for_life():
    shapes = [{name: (a.shape, a.dtype) for name, a in state_of(*trained(n)).items()} for n in (0, 2)]
    assert shapes[0] == shapes[1]


def test_a_fresh_state_is_that_of_an_optimizer_that_has_not_begun():
    net, adam = trained(0)
    assert fingerprint(fresh_state(net.state_dict(), network())) == fingerprint(state_of(net, adam))


def test_moments_are_kept_of_what_is_trained_alone():
    state = state_of(*trained(1))
    assert "model.0.weight" in state
    assert "adam.exp_avg.0.weight" not in state
    assert state["adam.step"].tolist() == [1.0] * 5


def test_a_state_shares_no_memory_with_the_module():
    net, adam = trained(1)
    state = state_of(net, adam)
    before = fingerprint(state)
    step(net, adam, seed=5)
    restore(state, net, adam)
    step(net, adam, seed=5)
    assert fingerprint(state) == before


def test_read_only_states_can_be_restored():
    net, adam = trained(1)
    state = state_of(net, adam)
    for array in state.values():
        array.flags.writeable = False
    restore(state, net, adam)
