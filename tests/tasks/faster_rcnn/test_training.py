"""Training: weights that move, states that are left alone, and what may go wrong."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from toy_detection import squares

from tacos_framework.contracts import Budget
from tacos_framework.errors import CandidateFailed, UserError
from tacos_framework.testing.fingerprint import fingerprint

pytest.importorskip("torchvision", reason="the extra perception is not installed")

import torch

from tacos_plugins.tasks.faster_rcnn import task as task_module
from tacos_plugins.tasks.faster_rcnn import training as training_module
from tacos_plugins.tasks.faster_rcnn.task import INDOOR_CLASSES, FasterRcnn
from tacos_plugins.tasks.learning.guard import TrainingDiverged


def detector(**settings):
    config = {
        "backbone": "narrow-fpn",
        "classes": ("sofa", "bed"),
        "batch_norm": "update",
        "proposals": 30,
        "rois": 16,
        "device": "cpu",
        **settings,
    }
    return FasterRcnn(FasterRcnn.Config(**config))


def first_state(task, seed=1):
    return task.initial_state(rng=np.random.default_rng(seed))


def fitted(task, state, batches, epochs=1, seed=2, on_step=None, **settings):
    budget = Budget(epochs, settings, on_step)
    return task.fit(batches, state=state, budget=budget, rng=np.random.default_rng(seed))


def moved(before, after):
    """Names of entries that differ."""
    return {name for name in before if not np.array_equal(before[name], after[name])}


def test_every_weight_moves_and_the_old_state_stays():
    task = detector()
    state = first_state(task)
    before = fingerprint(state)
    after = fitted(task, state, [squares(8)], learning_rate=1e-3)
    assert fingerprint(state) == before
    parameters = {f"model.{name}" for name, p in task._model().named_parameters()}
    assert parameters <= moved(state, after)
    assert set(after) == set(state)


def test_the_paper_s_rate_moves_them_too():
    task = detector(batch_norm="frozen")
    state = first_state(task)
    after = fitted(task, state, [squares(4)])
    weights = [name for name in state if name.startswith("model.") and name.endswith("conv1.weight")]
    assert weights
    for name in weights:
        step = np.abs(after[name] - state[name])
        assert 0.5e-4 < step.max() < 2e-4  # Adam's first step is as long as its rate


def test_frozen_batch_normalisation_stays_where_it_is_and_updated_one_moves():
    for mode, moves in (("frozen", False), ("update", True)):
        task = detector(batch_norm=mode)
        state = first_state(task)
        after = fitted(task, state, [squares(4)])
        norms = [name for name in state if name.endswith("running_mean")]
        gains = [name.replace("running_mean", "weight") for name in norms]
        assert norms
        assert (moved(state, after) >= {*norms, *gains}) is moves
        assert bool(moved(state, after) & {*norms, *gains}) is moves


def test_it_learns_to_find_squares():
    task = detector(minimum_share=0.0)
    state = first_state(task)
    losses = []
    batches = [squares(16, seed) for seed in range(4)]
    for epoch in range(6):
        state = fitted(
            task, state, batches, seed=epoch, on_step=losses.append, learning_rate=2e-3, decay_every=100
        )
    assert np.mean([each["loss"] for each in losses[-8:]]) < 0.5 * losses[0]["loss"]
    assert {"loss", "loss_classifier", "loss_objectness"} <= losses[0].keys()
    unseen = [squares(8, seed) for seed in (90, 91)]
    scores = [scored(task, weights, unseen)["ap50"] for weights in (first_state(task), state)]
    assert scores[1] > scores[0] + 0.3


def scored(task, state, batches):
    scorer = task.begin(state=state)
    for frames in batches:
        scorer.update(frames)
    return scorer.scores()


def test_training_repeats_itself_bit_for_bit_and_does_not_touch_torch_s_generator():
    task = detector()
    state = first_state(task)
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    runs = [fitted(task, state, [squares(8)]) for _ in range(2)]
    assert fingerprint(runs[0]) == fingerprint(runs[1])
    assert torch.equal(torch.rand(3), expected)
    assert fingerprint(fitted(task, state, [squares(8)], seed=3)) != fingerprint(runs[0])


def test_going_on_from_a_state_equals_not_having_stopped():
    """Moments, steps and the count of passes are all in the state."""
    task = detector()
    state = first_state(task)
    halves = state
    for _ in range(2):
        halves = fitted(task, halves, [squares(4)], decay_every=1, mirror=False, shuffled_frames=1)
    whole = fitted(task, state, [squares(4)], epochs=2, decay_every=1, mirror=False, shuffled_frames=1)
    assert halves["schedule.steps"] == whole["schedule.steps"] == [2]
    # the generator of the second half differs, so compare what does not depend on which regions were drawn
    assert np.array_equal(halves["adam.step"], whole["adam.step"])
    assert all(steps == 2 for steps in whole["adam.step"])


@pytest.fixture
def rates(monkeypatch) -> list[float]:
    """The learning rate of each step that is taken."""
    rates = []
    step = training_module._step
    monkeypatch.setattr(
        training_module,
        "_step",
        lambda model, adam, *rest: rates.append(adam.param_groups[0]["lr"]) or step(model, adam, *rest),
    )
    return rates


def test_the_schedule_goes_on_from_call_to_call(rates):
    task = detector()
    state = first_state(task)
    for _ in range(3):
        state = fitted(task, state, [squares(2)], decay_every=1, decay_floor=0.3)
    assert rates == pytest.approx([1e-4, 5e-5, 3e-5])


def test_the_first_steps_are_smaller_where_the_rate_warms_up(rates):
    """Counted over all trainings, not within one."""
    task = detector()
    state = first_state(task)
    for _ in range(3):
        state = fitted(task, state, [squares(4)], batch_size=2, warm_up_steps=4)
    assert rates == pytest.approx([0.25e-4, 0.5e-4, 0.75e-4, 1e-4, 1e-4, 1e-4])


def test_a_gradient_is_scaled_down_to_its_limit(monkeypatch):
    norms = []
    clip = torch.nn.utils.clip_grad_norm_

    def noting(parameters, limit):
        parameters = list(parameters)
        clip(parameters, limit)
        norms.append(float(torch.stack([p.grad.norm() for p in parameters if p.grad is not None]).norm()))

    monkeypatch.setattr(torch.nn.utils, "clip_grad_norm_", noting)
    task = detector()
    state = first_state(task)
    fitted(task, state, [squares(2)])
    assert norms == []
    fitted(task, state, [squares(2)], gradient_limit=1e-3)
    assert norms == pytest.approx([1e-3], rel=1e-3)


def test_frames_without_objects_are_learnt_from_too():
    empty = squares(4, classes=("threshold",))
    task = detector()
    state = first_state(task)
    after = fitted(task, state, [empty])
    assert moved(state, after)
    assert scored(task, after, [empty]) == {}


def test_a_loss_that_is_no_number_fails_the_candidate_and_leaves_the_weights(monkeypatch):
    task = detector()
    state = first_state(task)
    before = fingerprint(state)
    poisoned = {**state, "model.roi_heads.box_head.fc6.bias": np.full(128, np.nan, np.float32)}
    with pytest.raises(
        TrainingDiverged, match=r"task.faster-rcnn diverged: its loss is nan at step 0"
    ) as caught:
        fitted(task, poisoned, [squares(4)])
    assert isinstance(caught.value, CandidateFailed)
    assert fingerprint(state) == before


def test_out_of_memory_halves_the_batch_once_then_says_what_to_do(monkeypatch, caplog):
    sizes = []
    step = training_module._step

    def short_of_memory(most):
        def act(model, adam, batch, *rest):
            sizes.append(len(batch))
            if len(batch) > most:
                raise torch.OutOfMemoryError("out of memory")
            return step(model, adam, batch, *rest)

        return act

    task = detector(batch_norm="frozen")
    state = first_state(task)
    monkeypatch.setattr(training_module, "_step", short_of_memory(2))
    with caplog.at_level(logging.WARNING):
        after = fitted(task, state, [squares(4)], batch_size=4)
    assert sizes == [4, 2, 2]
    assert moved(state, after)
    assert "training anew with batches of 2" in caplog.text
    monkeypatch.setattr(training_module, "_step", short_of_memory(1))
    with pytest.raises(UserError, match="runs out of memory with batches of 2"):
        fitted(task, state, [squares(4)], batch_size=4)


def test_a_mono_camera_is_trained_and_scored():
    task = detector()
    grey = squares(4, mono=True)
    state = first_state(task)
    assert "ap50" in scored(task, fitted(task, state, [grey]), [grey])


def test_cuda_that_is_not_there_is_refused_at_once():
    if torch.cuda.is_available():
        pytest.skip("there is a GPU")
    with pytest.raises(UserError, match="device is cuda"):
        detector(device="cuda")


def test_a_scorer_needs_weights_and_a_camera_that_is_there():
    task = detector()
    with pytest.raises(ValueError, match="begin needs a state"):
        task.begin(state=None)
    other = detector(camera="camra")
    with pytest.raises(UserError, match="Did you mean 'camera'"):
        scored(other, first_state(other), [squares(1)])


def test_a_batch_in_parts_is_one_step(monkeypatch):
    """Memory for one frame is enough for a batch of four: gradients are summed up."""
    seen = []
    finite = training_module.finite
    monkeypatch.setattr(
        training_module, "finite", lambda loss, **facts: seen.append(facts["step"]) or finite(loss, **facts)
    )
    task = detector(batch_norm="frozen")
    state = first_state(task)
    losses_seen = []
    after = fitted(task, state, [squares(4)], batch_size=4, frames_at_once=1, on_step=losses_seen.append)
    assert seen == [0, 0, 0, 0]
    assert len(losses_seen) == 1
    assert set(after["adam.step"]) == {1.0}
    together = []
    fitted(task, state, [squares(4)], batch_size=4, on_step=together.append)
    assert losses_seen[0]["loss"] == pytest.approx(together[0]["loss"], rel=0.1)  # other regions were drawn


@pytest.mark.parametrize(("weights", "moves"), [("none", True), ("detector_indoor_narrow", False)])
def test_batch_normalisation_learns_by_default_only_from_nothing(weights, moves):
    task = detector(batch_norm="auto", weights=weights, classes=INDOOR_CLASSES)
    state = first_state(task)
    after = fitted(task, state, [squares(4)])
    assert any(name.endswith("running_mean") for name in moved(state, after)) is moves


def test_half_precision_trains_and_scores(monkeypatch):
    """What a GPU does, on the CPU."""
    monkeypatch.setattr(
        training_module, "mixed_precision", lambda device: torch.autocast(device.type, torch.bfloat16)
    )
    monkeypatch.setattr(
        task_module, "mixed_precision", lambda device: torch.autocast(device.type, torch.bfloat16)
    )
    task = detector()
    state = first_state(task)
    after = fitted(task, state, [squares(4)])
    assert moved(state, after)
    assert {after[name].dtype for name in after} == {state[name].dtype for name in state}
    assert 0 <= scored(task, after, [squares(2)])["ap50"] <= 1
