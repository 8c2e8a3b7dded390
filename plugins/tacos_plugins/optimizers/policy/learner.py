"""Stable-Baselines3's PPO without its loop: the policy acts when asked, and learns from what it is given."""

from __future__ import annotations

import base64
import warnings
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.numpy import load, save
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.type_aliases import RolloutBufferSamples
from stable_baselines3.common.vec_env import DummyVecEnv

_KEPT = ("observations", "actions", "rewards", "episode_starts", "values", "log_probs")
"""Arrays of a rollout under way."""


@dataclass(frozen=True, eq=False)
class Acted:
    """Actions of the policy, one for each camera."""

    observations: NDArray[np.float32]
    """(count, genes) float32 what it saw."""
    actions: NDArray[np.float32]
    """(count, genes) float32 what it drew, unclipped."""
    values: NDArray[np.float32]
    log_probs: NDArray[np.float32]
    """(count,) float32 what it expected, and how likely the actions were."""


class Learner:
    """A policy and value network, the rollout under way, and PPO's update.

    Nothing global is seeded or drawn from: actions and the order of minibatches come from `rng`, and so does
    the seed of the first weights. It computes on the CPU, where the networks are too small for a GPU to help.

    - `rollout`: steps of each camera between two updates.
    - `hidden`: units of the hidden layers, of the policy and of the value alike.
    - `update`: further arguments of `stable_baselines3.PPO`.
    """

    def __init__(
        self,
        count: int,
        dimension: int,
        rollout: int,
        hidden: tuple[int, ...],
        update: dict[str, Any],
        rng: np.random.Generator,
    ) -> None:
        self._rng = rng
        places: list[Callable[[], gymnasium.Env[Any, Any]]] = [lambda: _Places(dimension)] * count
        with torch.random.fork_rng(devices=[]), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a last minibatch that is smaller does no harm
            torch.manual_seed(int(rng.integers(2**31)))
            self._ppo = PPO(
                "MlpPolicy",
                DummyVecEnv(places),
                n_steps=rollout,
                rollout_buffer_class=_SeededBuffer,
                rollout_buffer_kwargs={"rng": rng},
                policy_kwargs={"net_arch": list(hidden)},
                device="cpu",
                **update,
            )
        self._ppo.set_logger(Logger(folder=None, output_formats=[]))
        self._buffer: RolloutBuffer = self._ppo.rollout_buffer
        self._begins = True

    def act(self, observations: NDArray[np.float32]) -> Acted:
        """Draw an action for each of (count, genes) observations."""
        seen = torch.from_numpy(observations)
        with torch.no_grad():
            normal = self._ppo.policy.get_distribution(seen).distribution
            assert isinstance(normal, torch.distributions.Normal)  # what a box of actions has
            noise = torch.from_numpy(self._rng.standard_normal(observations.shape, dtype=np.float32))
            actions = normal.mean + normal.stddev * noise
            log_probs = normal.log_prob(actions).sum(dim=1)
            values = self._ppo.policy.predict_values(seen).flatten()
        return Acted(observations, actions.numpy(), values.numpy(), log_probs.numpy())

    def learn(
        self,
        acted: Acted,
        rewards: NDArray[np.float32],
        reached: NDArray[np.float32],
        following: NDArray[np.float32],
        over: bool,
    ) -> None:
        """Take in what came of a step; at the end of a rollout, update the networks.

        - `rewards`: (count,) float32.
        - `reached`, `following`: (count, genes) observations of where the actions led, and of where the next
          ones begin.
        - `over`: whether the cameras' time was over: they could have gone on, so that what was to come
          counts.
        """
        with torch.no_grad():
            if over:
                to_come = self._ppo.policy.predict_values(torch.from_numpy(reached)).flatten().numpy()
                rewards = (rewards + self._ppo.gamma * to_come).astype(np.float32)
            next_values = self._ppo.policy.predict_values(torch.from_numpy(following))
        count = len(rewards)
        self._buffer.add(
            acted.observations,
            acted.actions,
            rewards,
            np.full(count, self._begins, np.float32),
            torch.from_numpy(acted.values),
            torch.from_numpy(acted.log_probs),
        )
        self._begins = over
        if self._buffer.full:
            self._buffer.compute_returns_and_advantage(next_values, np.full(count, over))
            self._ppo.train()
            self._buffer.reset()

    def state(self) -> dict[str, Any]:
        """Weights, moments of Adam and the rollout under way, as JSON values; the generator is left out."""
        arrays = {f"policy.{name}": t.numpy() for name, t in self._ppo.policy.state_dict().items()}
        moments = self._ppo.policy.optimizer.state_dict()["state"]
        for number, of_parameter in moments.items():
            arrays |= {f"adam.{number}.{name}": np.asarray(t) for name, t in of_parameter.items()}
        arrays |= {f"rollout.{name}": getattr(self._buffer, name)[: self._buffer.pos] for name in _KEPT}
        packed = save({name: np.array(array, order="C") for name, array in arrays.items()})
        return {"arrays": base64.b64encode(packed).decode("ascii"), "begins": self._begins}

    def restore(self, state: dict[str, Any]) -> None:
        arrays = load(base64.b64decode(state["arrays"]))
        weights = {
            name.removeprefix("policy."): torch.from_numpy(array.copy())
            for name, array in arrays.items()
            if name.startswith("policy.")
        }
        self._ppo.policy.load_state_dict(weights)
        optimizer = self._ppo.policy.optimizer
        moments: dict[int, dict[str, torch.Tensor]] = {}
        for name, array in arrays.items():
            if name.startswith("adam."):
                _, number, what = name.split(".")
                moments.setdefault(int(number), {})[what] = torch.from_numpy(array.copy())
        optimizer.load_state_dict({**optimizer.state_dict(), "state": moments})
        self._buffer.reset()
        taken = len(arrays["rollout.rewards"])
        for name in _KEPT:
            getattr(self._buffer, name)[:taken] = arrays[f"rollout.{name}"]
        self._buffer.pos = taken
        self._begins = state["begins"]


class _Places(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Tells PPO the shapes; nothing is ever done in it, as steps are taken where they are asked for."""

    def __init__(self, dimension: int) -> None:
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (dimension,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (dimension,), np.float32)


class _SeededBuffer(RolloutBuffer):
    """Shuffles with a generator of its own, where the original draws from numpy's global one."""

    def __init__(self, *arguments: Any, rng: np.random.Generator, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self._rng = rng

    def get(self, batch_size: int | None = None) -> Generator[RolloutBufferSamples, None, None]:
        """Every transition once, in minibatches."""
        order = self._rng.permutation(self.buffer_size * self.n_envs)
        if not self.generator_ready:
            for name in ("observations", "actions", "values", "log_probs", "advantages", "returns"):
                setattr(self, name, self.swap_and_flatten(getattr(self, name)))
            self.generator_ready = True
        size = batch_size or len(order)
        for start in range(0, len(order), size):
            yield self._get_samples(order[start : start + size])
