"""The task `task.faster-rcnn`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import ClassVar, Literal

import numpy as np
import torch
from torchvision.models.detection import FasterRCNN

from tacos_framework import Budget, FrameBatch, Scores, ScoreScale, Settings, State, setting
from tacos_plugins.tasks.chosen_camera import camera_index
from tacos_plugins.tasks.faster_rcnn.average_precision import AveragePrecision, Detections
from tacos_plugins.tasks.faster_rcnn.examples import Example
from tacos_plugins.tasks.faster_rcnn.images import CameraPixels
from tacos_plugins.tasks.faster_rcnn.labels import class_numbers, frame_labels
from tacos_plugins.tasks.faster_rcnn.networks import Backbone, faster_rcnn, still_norms
from tacos_plugins.tasks.faster_rcnn.training import WHERE, DetectorTraining, inputs, train
from tacos_plugins.tasks.faster_rcnn.weights import COCO, load_weights, weights_file
from tacos_plugins.tasks.learning.checkpoints import NONE
from tacos_plugins.tasks.learning.device import (
    DEVICE_HELP,
    DEVICE_PATTERN,
    drawing_from,
    mixed_precision,
    pick_device,
)
from tacos_plugins.tasks.learning.guard import halving_batch_once, naming_lack_of_memory
from tacos_plugins.tasks.learning.states import fresh_state, restore, state_of

INDOOR_CLASSES = ("sofa", "bed", "table", "chair", "bathtub", "basin", "computer_tv", "plant", "lamp", "toy")
"""The classes of the paper's headset study."""

FRAMES_AT_ONCE = {"cpu": 1, "cuda": 8}
"""Frames scored together; on a CPU nothing is gained by more than one."""


class FasterRcnn:
    """Faster R-CNN, trained on the frames of each candidate and scored by average precision.

    What there is to detect comes from the ids of the capture: a box around the visible pixels of each object
    of the classes asked for. Images reach the network with the camera's own pixels, so that resolution tells.

    ``ap50``
        Average precision at an intersection over union of 0.5, in 0..1, the mean over the classes of which
        objects came into sight; higher is better. An episode without any has no score.
    ``ap50_CLASS``
        That of each of these classes.

    Batch normalisation keeps its statistics, gains and offsets in a study: batches of a few frames of a
    single camera would pull them to and fro between candidates. A detector that starts from nothing needs it
    to learn, and it then does.

    Sources: The paper, Sec. 4.3, "Object Detector"; Ren et al. 2015, "Faster R-CNN"; Lin et al. 2017,
    "Feature pyramid networks for object detection".
    """

    class Config(Settings):
        camera: str | None = setting(None, help="Name of the camera that is scored; by default the first.")
        backbone: Backbone = setting(
            "resnet50-fpn", help="The network: the paper's, a lighter one, or a small one for CPUs."
        )
        weights: str = setting(
            "none",
            help="Initial weights: none, a file, shipped weights by name, or coco (torchvision's own).",
            is_path=True,
        )
        classes: tuple[str, ...] = setting(
            INDOOR_CLASSES,
            help="Classes of objects to detect; those that a world does not know are not met.",
            min_length=1,
        )
        minimum_area_px: int = setting(
            16, help="Visible pixels below which an object need not be found.", unit="px", ge=1
        )
        minimum_share: float = setting(
            0.001,
            help="Share of the image below which it need not: many pixels do not make the task harder.",
            ge=0,
            lt=1,
        )
        scale: float = setting(1.0, help="Size of the network's image over the camera's.", gt=0, le=8)
        min_size: int | None = setting(
            None,
            help="Least short side of the network's image; by default the camera's own.",
            unit="px",
            ge=1,
        )
        max_size: int | None = setting(
            None, help="Most long side of the network's image; by default the camera's own.", unit="px", ge=1
        )
        encoding: Literal["srgb", "linear"] = setting(
            "srgb", help="Encoding of the network's input: for a display (srgb), or linear as in the sensor."
        )
        proposals: int = setting(200, help="Regions the first stage proposes.", ge=1)
        rois: int = setting(64, help="Regions of an image either stage is trained on.", ge=4)
        detections: int = setting(100, help="Detections of an image at most.", ge=1)
        score_threshold: float = setting(0.05, help="Confidence below which nothing is detected.", ge=0, lt=1)
        smallest_anchor_px: float | None = setting(
            None,
            help="Edge of the smallest anchors; by default the backbone's own, 32 or 12.",
            unit="px",
            gt=0,
        )
        batch_norm: Literal["auto", "frozen", "update"] = setting(
            "auto", help="Train batch normalisation; auto: only where weights is none."
        )
        device: str = setting("auto", help=DEVICE_HELP, pattern=f"^({DEVICE_PATTERN})$")

    Training: ClassVar[type[Settings]] = DetectorTraining

    needs: ClassVar[tuple[str, ...]] = ("objects",)
    scores: ClassVar[tuple[str, ...]] = ("ap50", *(f"ap50_{name}" for name in INDOOR_CLASSES))
    score_scales: ClassVar[Mapping[str, ScoreScale]] = dict.fromkeys(scores, "share")
    margins: ClassVar[Mapping[str, float]] = dict.fromkeys(scores, 0.02)
    """Two points of average precision, a little more than its standard error over sixteen worlds."""
    score_meanings: ClassVar[Mapping[str, str]] = {
        "ap50": "average precision of detection, a box counting from an overlap of 50 %"
    }

    def __init__(self, config: Config) -> None:
        self.config = config
        self._device = pick_device(config.device, where=WHERE)
        weights_file(config.weights)  # what is not there shows before anything is rendered

    def initial_state(self, *, rng: np.random.Generator) -> State:
        """The weights the settings name, or random ones."""
        with drawing_from(rng):
            model = self._model()
        load_weights(model, self.config.weights, self.config.backbone)
        return fresh_state(model.state_dict(), model)

    def untrained(self) -> str | None:
        """Why the weights the settings name detect nothing yet; None where they know its classes."""
        reasons = {
            NONE: "weights is none, so they are random",
            COCO: "weights is coco, whose last layer knows other classes and starts at random",
        }
        reason = reasons.get(self.config.weights)
        return reason and f"{reason}; procedure.pretrain makes trained ones (pretrain_detector)"

    def fit(
        self, batches: Iterable[FrameBatch], *, state: State, budget: Budget, rng: np.random.Generator
    ) -> State:
        """Weights, moments and schedule after training; see `DetectorTraining` for the budget's settings."""
        training = DetectorTraining.model_validate(dict(budget.settings or {}))
        seed = int(rng.integers(2**63))
        attempt = partial(self._fit, batches, state, budget, training, seed)
        return halving_batch_once(attempt, training.batch_size, where=WHERE)

    def _fit(
        self,
        batches: Iterable[FrameBatch],
        state: State,
        budget: Budget,
        training: DetectorTraining,
        seed: int,
        batch_size: int,
    ) -> State:
        rng = np.random.default_rng(seed)
        with drawing_from(rng, self._device):
            model = self._model()
            moving = [p for p in model.parameters() if p.requires_grad]
            model.to(self._device)
            adam = torch.optim.Adam(moving, lr=training.learning_rate)
            passes = train(
                model,
                adam,
                lambda: self.examples(batches),
                epochs=budget.epochs,
                passes=restore(state, model, adam),
                training=training,
                batch_size=batch_size,
                norms=self._moves_norms,
                rng=rng,
                on_step=budget.on_step,
            )
        return state_of(model, adam, schedule_steps=passes)

    def begin(self, *, state: State | None) -> DetectionScorer:
        if state is None:
            raise ValueError(
                f"{WHERE} scores with trained weights: begin needs a state, as initial_state gives"
            )
        with drawing_from(np.random.default_rng(0)):  # weights that are replaced at once
            model = self._model()
        restore(state, model)
        return DetectionScorer(self, model.to(self._device).eval(), self._device)

    def examples(self, batches: Iterable[FrameBatch]) -> Iterator[Example]:
        """The frames of the camera that is scored, with their labels."""
        for frames in batches:
            index = camera_index(frames, self.config.camera, where=WHERE)
            view = frames.capture.views[index]
            class_of_object = class_numbers(frames.episode.world, self.config.classes)
            for image, ids in zip(frames.images[index], view.object_id, strict=True):
                labels = frame_labels(
                    ids,
                    class_of_object,
                    minimum_area_px=self.config.minimum_area_px,
                    minimum_share=self.config.minimum_share,
                )
                yield Example(image, frames.black_level_dn, frames.white_level_dn, labels)

    @property
    def wants(self) -> Literal["linear", "coded"]:
        return "coded" if self.config.encoding == "srgb" else "linear"

    @property
    def frames_per_update(self) -> int:
        """As many as the network takes at once: several on a GPU, one on a CPU."""
        return FRAMES_AT_ONCE[self._device.type]

    @property
    def _moves_norms(self) -> bool:
        wanted = self.config.batch_norm
        return wanted == "update" or (wanted == "auto" and self.config.weights == NONE)

    def _model(self) -> FasterRCNN:
        config = self.config
        model = faster_rcnn(
            config.backbone,
            len(config.classes),
            proposals=config.proposals,
            rois=config.rois,
            detections=config.detections,
            score_threshold=config.score_threshold,
            smallest_anchor_px=config.smallest_anchor_px,
            pixels=CameraPixels(config.scale, config.min_size, config.max_size),
        )
        if not self._moves_norms:
            still_norms(model)
        if self._device.type == "cuda":
            model.to(memory_format=torch.channels_last)
        return model


class DetectionScorer:
    """Scores one episode; keeps boxes alone."""

    def __init__(self, task: FasterRcnn, model: FasterRCNN, device: torch.device) -> None:
        self._task, self._model, self._device = task, model, device
        config = task.config
        self._precision = AveragePrecision(config.classes, detections=config.detections)

    def update(self, frames: FrameBatch) -> None:
        examples = list(self._task.examples([frames]))
        at_once = FRAMES_AT_ONCE[self._device.type]
        for start in range(0, len(examples), at_once):
            part = examples[start : start + at_once]
            for example, found in zip(part, self.detect(part), strict=True):
                self._precision.add(example.labels, found)

    def detect(self, examples: Sequence[Example]) -> list[Detections]:
        with (
            torch.inference_mode(),
            mixed_precision(self._device),
            naming_lack_of_memory(f"{WHERE} runs out of memory", where=WHERE),
        ):
            found = self._model(inputs(examples, self._device))
        return [
            Detections(
                each["boxes"].float().cpu().numpy(),
                each["labels"].cpu().numpy(),
                each["scores"].float().cpu().numpy(),
            )
            for each in found
        ]

    def scores(self) -> Scores:
        return self._precision.scores("ap50")
