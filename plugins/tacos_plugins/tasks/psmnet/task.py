"""The task `task.psmnet`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import ClassVar, Literal

import numpy as np
import torch
from numpy.typing import NDArray

from tacos_framework import (
    Budget,
    Camera,
    CandidateFailed,
    FrameBatch,
    Rig,
    Scores,
    ScoreScale,
    Settings,
    State,
    setting,
)
from tacos_plugins.tasks.learning.checkpoints import load_checkpoint, named_weights, read_checkpoint
from tacos_plugins.tasks.learning.device import DEVICE_HELP, DEVICE_PATTERN, drawing_from, pick_device
from tacos_plugins.tasks.learning.guard import halving_batch_once, naming_lack_of_memory
from tacos_plugins.tasks.learning.states import fresh_state, restore, state_of
from tacos_plugins.tasks.psmnet.network import MULTIPLE_PX, PSMNet
from tacos_plugins.tasks.psmnet.training import SMALLEST_PX, WHERE, PsmnetTraining, network_pairs, train
from tacos_plugins.tasks.stereo.depth_scores import ERRORS, MARGINS, MEANINGS, SCALES, SCORES, DepthScores
from tacos_plugins.tasks.stereo.examples import StereoExample, stereo_examples
from tacos_plugins.tasks.stereo.pair import StereoPair, stereo_pair


class PsmnetDepth:
    """Depth from stereo by PSMNet, trained on the frames of each candidate.

    The true disparity of a pixel is ``f b / Z`` with the candidate's own focal length in pixels, its baseline
    and the depth that was rendered. Both images reach the network alike: encoded for a display and
    normalised once by ImageNet's mean and deviation.

    The scores are those of `DepthScores`.

    Source: the paper, Sec. 4.2, "Stereo Matching Network"; Chang and Chen 2018, "Pyramid stereo matching
    network".
    """

    class Config(Settings):
        left: str | None = setting(None, help="Name of the left camera; by default the first.")
        right: str | None = setting(None, help="Name of the right camera; by default the second.")
        weights: str = setting(
            "none",
            help="Initial weights: none, a file (published checkpoints too), or shipped weights by name.",
            is_path=True,
        )
        max_disparity: int = setting(
            192,
            help="Disparities from here on are not told apart; a multiple of 16.",
            unit="px",
            ge=MULTIPLE_PX,
            multiple_of=MULTIPLE_PX,
        )
        width: float = setting(
            1.0, help="Factor on the channels of all layers; 1 is the published network.", ge=0.1, le=4
        )
        max_depth_m: float = setting(
            1000.0, help="Depths are capped here; what lies beyond is sky.", unit="m", gt=0
        )
        encoding: Literal["srgb", "linear"] = setting(
            "srgb", help="Encoding of the network's input: for a display (srgb), or linear as in the sensor."
        )
        align_corners: bool = setting(
            True,
            help="Alignment when volumes are enlarged; the authors advise true for their published weights.",
        )
        device: str = setting("auto", help=DEVICE_HELP, pattern=f"^({DEVICE_PATTERN})$")

    Training = PsmnetTraining

    needs: ClassVar[tuple[str, ...]] = ("depth",)
    scores: ClassVar[tuple[str, ...]] = SCORES
    margins: ClassVar[Mapping[str, float]] = MARGINS
    score_meanings: ClassVar[Mapping[str, str]] = MEANINGS
    lower_is_better: ClassVar[frozenset[str]] = ERRORS
    score_scales: ClassVar[Mapping[str, ScoreScale]] = SCALES

    def __init__(self, config: Config) -> None:
        self.config = config
        self._device = pick_device(config.device, where=WHERE)
        self._weights = named_weights(config.weights, where=f"{WHERE}: weights")

    @property
    def wants(self) -> Literal["linear", "coded"]:
        return "coded" if self.config.encoding == "srgb" else "linear"

    def lacks(self, rig: Rig) -> str | None:
        """Why the cameras of a rig are no pair for it, in a sentence; None when they are."""
        try:
            self._pair(rig.cameras)
        except CandidateFailed as error:
            return str(error)
        return None

    def initial_state(self, *, rng: np.random.Generator) -> State:
        """The weights the settings name, or random ones."""
        with drawing_from(rng):
            network = self._network()
        if self._weights is not None:
            where = f"{WHERE}: weights {self._weights}"
            tensors = read_checkpoint(self._weights, where=where)
            load_checkpoint(tensors, network, where=where, made_for=f"PSMNet of width {self.config.width:g}")
        return fresh_state(network.state_dict(), network)

    def untrained(self) -> str | None:
        """Why the weights the settings name match nothing yet; None where a file has them."""
        if self._weights is not None:
            return None
        return "weights is none, so they are random; procedure.pretrain makes trained ones (pretrain_stereo)"

    def fit(
        self, batches: Iterable[FrameBatch], *, state: State, budget: Budget, rng: np.random.Generator
    ) -> State:
        """Weights and moments after training; see `PsmnetTraining` for the budget's settings."""
        training = PsmnetTraining.model_validate(dict(budget.settings or {}))
        seed = int(rng.integers(2**63))
        attempt = partial(self._fit, batches, state, budget, training, seed)
        return halving_batch_once(attempt, training.batch_size, where=WHERE)

    def _fit(
        self,
        batches: Iterable[FrameBatch],
        state: State,
        budget: Budget,
        training: PsmnetTraining,
        seed: int,
        batch_size: int,
    ) -> State:
        network = self._empty_network()
        adam = torch.optim.Adam(network.parameters(), lr=training.learning_rate)
        restore(state, network, adam)
        train(
            network,
            adam,
            lambda: self.examples(batches),
            epochs=budget.epochs,
            training=training,
            batch_size=batch_size,
            max_depth_m=self.config.max_depth_m,
            rng=np.random.default_rng(seed),
            on_step=budget.on_step,
        )
        return state_of(network, adam)

    def begin(self, *, state: State | None) -> PsmnetScorer:
        if state is None:
            raise ValueError(f"{WHERE} scores with weights: begin needs a state, as initial_state gives")
        network = self._empty_network()
        restore(state, network)
        return PsmnetScorer(self, network.eval())

    def examples(self, batches: Iterable[FrameBatch]) -> Iterator[StereoExample]:
        """The pairs of batches, with their truth."""
        for frames in batches:
            pair = self._pair([view.camera for view in frames.capture.views])
            yield from stereo_examples(frames, pair)

    def _pair(self, cameras: Sequence[Camera]) -> StereoPair:
        return stereo_pair(
            cameras,
            left=self.config.left,
            right=self.config.right,
            smallest_px=SMALLEST_PX,
            largest_px=self.config.max_disparity,
            max_depth_m=self.config.max_depth_m,
        )

    def _network(self) -> PSMNet:
        config = self.config
        return PSMNet(config.max_disparity, width=config.width, align_corners=config.align_corners)

    def _empty_network(self) -> PSMNet:
        """A network on the device, whose weights are yet to be restored."""
        with torch.device("meta"):
            network = self._network()
        return network.to_empty(device=self._device)


class PsmnetScorer:
    """Scores one episode; keeps sums alone."""

    def __init__(self, task: PsmnetDepth, network: PSMNet) -> None:
        self._task, self._network = task, network
        self._scores = DepthScores(task.config.max_depth_m)

    def update(self, frames: FrameBatch) -> None:
        for example in self._task.examples([frames]):
            self._scores.add(self.disparity_px(example), example.depth_m, example.pair)

    def disparity_px(self, example: StereoExample) -> NDArray[np.float32]:
        """(H, W) estimated disparities of the left image [px]."""
        device = next(self._network.parameters()).device
        with (
            torch.inference_mode(),
            naming_lack_of_memory(f"{WHERE} runs out of memory on a single pair", where=WHERE),
        ):
            (found,) = self._network(*network_pairs([example], device))
            return found[0].cpu().numpy()

    def scores(self) -> Scores:
        return self._scores.scores()
