"""Proximal policy optimization: the published reinforcement learning of cameras, as one optimizer of many."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tacos_framework import Candidate, DesignSpace, Evaluated, Fault, Settings, UserError, setting
from tacos_plugins.optimizers.observed_results import validate_results
from tacos_plugins.optimizers.policy.designers import Designers, RewardScale
from tacos_plugins.optimizers.unit_cube import UnitCube

if TYPE_CHECKING:
    from tacos_plugins.optimizers.policy.learner import Learner


class Ppo:
    """A network that learns which change of a camera makes it better, by proximal policy optimization.

    A camera begins anywhere in the space and is changed ``steps`` times, then another one begins;
    ``cameras`` of them are changed side by side. The policy sees the camera's genes, scaled to -1..1, and
    answers with a change of each of them. Each changed camera is a candidate: it is snapped to what can be
    manufactured and evaluated, and its fitness, or how much that gained, is the reward. After every
    ``rollout`` changes the policy is updated by PPO. The best candidate is kept by the study, not by the
    policy.

    Rewards are scaled by the mean and the spread of all fitness so far. A candidate that failed is rewarded
    as the worst one so far. A camera whose time is over could have been changed further, so what the value
    network expects of it is added to its last reward.

    Where it differs from the published method: that describes cameras by words of a grammar and trains the
    task in the same loop, which here is the study's part; its learning rates and rollouts are not published.
    The defaults are PPO's own as Stable-Baselines3 has them, with a shorter rollout (64 changes instead of
    2048), since a study affords some thousand candidates in all.

    Sources: Klinghoffer et al. 2023, "DISeR: Designing imaging systems with reinforcement learning", ICCV;
    Schulman et al. 2017, "Proximal policy optimization algorithms"; Raffin et al. 2021, "Stable-Baselines3",
    JMLR 22.

    >>> from tacos_framework.variables.design_space import Continuous
    >>> space = DesignSpace([Continuous("hfov_deg", 50, 120, "deg"), Continuous("baseline_m", 0.01, 3, "m")])
    >>> search = Ppo(Ppo.Config(evaluations=8), space=space, rng=np.random.default_rng(1))
    >>> while not (reason := search.stop()):
    ...     search.tell([Evaluated(c, -abs(c.values["baseline_m"] - 1.6)) for c in search.ask()])
    >>> reason
    'all 8 candidates were evaluated'
    """

    class Config(Settings):
        evaluations: int = setting(
            1000,
            help="Candidates asked in all; 1000 in the paper.",
            ge=1,
            also=("budget", "trials", "iterations"),
        )
        cameras: int = setting(
            4, help="Cameras changed side by side, which are the candidates asked at a time.", ge=1
        )
        steps: int = setting(16, help="Changes of a camera before another one begins.", ge=1)
        step_size: float = setting(
            0.2, help="Change of a gene by an action of 1, relative to its range.", gt=0, le=1
        )
        reward: Literal["fitness", "gain"] = setting(
            "fitness", help="Reward of a change: the fitness it leads to, or its gain."
        )
        rollout: int = setting(
            64, help="Changes between two updates of the policy, of all cameras together.", ge=2
        )
        minibatch: int = setting(16, help="Changes in each step of an update.", ge=2)
        epochs: int = setting(10, help="Passes over the changes in each update.", ge=1)
        learning_rate: float = setting(3e-4, help="Of Adam.", gt=0, also=("lr",))
        discount: float = setting(0.99, help="Discount of a reward for each later change.", ge=0, le=1)
        gae_lambda: float = setting(
            0.95,
            help="Between one step (0) and all rewards to come (1) in estimates of advantage.",
            ge=0,
            le=1,
        )
        clip: float = setting(
            0.2, help="Largest relative change of the probability of an action in an update.", gt=0, lt=1
        )
        entropy: float = setting(0.0, help="Weight of the policy's entropy, which keeps it exploring.", ge=0)
        hidden: tuple[int, ...] = setting((64, 64), help="Units of the hidden layers.", min_length=1)

    def __init__(self, config: Config, *, space: DesignSpace, rng: np.random.Generator) -> None:
        self.config = config
        self._cube = UnitCube(space)
        self._rng = rng
        self._scale = RewardScale()
        self._evaluated = 0
        self._designers = Designers(config.cameras, self._cube.dimension, config.steps, config.step_size, rng)
        self._last: list[float | None] = [None] * config.cameras
        self._learner = self._make_learner()
        self._draw()

    @property
    def expected_candidates(self) -> int:
        return self.config.evaluations

    def ask(self) -> list[Candidate]:
        """The cameras after their next change; the same ones until they are evaluated."""
        return list(self._asked)

    def tell(self, evaluated: Sequence[Evaluated]) -> None:
        """Take in the fitness, learn from it once a rollout is full, and draw the next changes.

        Raises `ValueError` when a fitness is NaN or infinite, or the results are not those of the candidates
        asked.
        """
        validate_results(evaluated, self._asked)
        self._evaluated += len(evaluated)
        rewards = self._rewards([result.fitness for result in evaluated])
        if self.stop() is not None:
            return  # the last round may be cut short, and there is nothing left to learn for
        reached = self._reached
        over = self._designers.advance(reached)
        if over:
            self._last = [None] * self.config.cameras
        self._learner.learn(
            self._acted, rewards, self._designers.observe(reached), self._designers.observe(), over
        )
        self._draw()

    def stop(self) -> str | None:
        """A reason once all evaluations are observed."""
        if self._evaluated < self.config.evaluations:
            return None
        return f"all {self.config.evaluations} candidates were evaluated"

    def state(self) -> dict[str, Any]:
        """Networks, cameras, rollout and generator, as JSON values.

        What is in flight is not kept but drawn again, from the generator as it was before.
        """
        return {
            "rng": self._rng_before,
            "evaluated": self._evaluated,
            "last": list(self._last),
            "scale": self._scale.state(),
            "designers": self._designers.state(),
            "learner": self._learner.state(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        self._rng.bit_generator.state = state["rng"]
        self._evaluated = state["evaluated"]
        self._last = list(state["last"])
        self._scale.restore(state["scale"])
        self._designers.restore(state["designers"])
        self._learner.restore(state["learner"])
        self._draw()

    # ------------------------------------------------------------------------------------------------------

    def _make_learner(self) -> Learner:
        try:
            from tacos_plugins.optimizers.policy.learner import Learner
        except ModuleNotFoundError as error:
            if error.name not in ("stable_baselines3", "gymnasium", "torch"):
                raise
            fault = Fault(
                "optimizer.ppo",
                f"the package {error.name} is not installed",
                "",
                "pip install tacos-framework[rl]",
            )
            raise UserError(fault) from error
        config = self.config
        return Learner(
            config.cameras,
            self._cube.dimension,
            max(2, -(-config.rollout // config.cameras)),
            config.hidden,
            {
                "batch_size": config.minibatch,
                "n_epochs": config.epochs,
                "learning_rate": config.learning_rate,
                "gamma": config.discount,
                "gae_lambda": config.gae_lambda,
                "clip_range": config.clip,
                "ent_coef": config.entropy,
            },
            self._rng,
        )

    def _draw(self) -> None:
        """Let the policy change the cameras; as many are asked as the evaluations still allow."""
        self._rng_before = self._rng.bit_generator.state
        self._acted = self._learner.act(self._designers.observe())
        self._reached = self._designers.moved(self._acted.actions)
        left = self.config.evaluations - self._evaluated
        self._asked = [self._cube.candidate(point) for point in self._reached[:left]]

    def _rewards(self, observed: Sequence[float | None]) -> np.ndarray[Any, np.dtype[np.float32]]:
        """(count,) float32 rewards of a round."""
        for value in observed:
            if value is not None:
                self._scale.learn(value)
        worst = 0.0 if self._scale.worst is None else self._scale.worst
        fitness = [worst if value is None else value for value in observed]
        if self.config.reward == "fitness":
            rewards = [self._scale.scaled(value) for value in fitness]
        else:
            before = [
                value if last is None else last for value, last in zip(fitness, self._last, strict=False)
            ]
            rewards = [(now - then) / self._scale.spread for now, then in zip(fitness, before, strict=True)]
        self._last = list(fitness)
        return np.array(rewards, np.float32)
