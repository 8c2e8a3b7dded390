"""`task.psmnet`: it learns, exactly so each time, and says what is wrong with what it is given."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from safetensors.numpy import save_file

from tacos_framework.contracts import Budget
from tacos_framework.errors import UserError
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.task import batch
from tacos_framework.values import Rig
from tests.tasks.stereo_frames import stereo_frames, stereo_rig

torch = pytest.importorskip("torch", reason="the extra perception is not installed")

from tacos_plugins.tasks.learning.guard import TrainingDiverged  # noqa: E402
from tacos_plugins.tasks.psmnet import task as task_module  # noqa: E402
from tacos_plugins.tasks.psmnet import training as training_module  # noqa: E402
from tacos_plugins.tasks.psmnet.network import PSMNet  # noqa: E402
from tacos_plugins.tasks.psmnet.task import PsmnetDepth  # noqa: E402

RIG = stereo_rig(width_px=64, height_px=32, focal_length_px=60.0)
NARROW = {"width": 0.1, "max_disparity": 16, "device": "cpu"}
ALL_AT_ONCE = {"shuffled_frames": 1}
"""With windows as large as the images nothing is left to chance."""


def make(**config):
    return PsmnetDepth(PsmnetDepth.Config(**{**NARROW, **config}))


def start(task=None, seed: int = 1):
    return (task or make()).initial_state(rng=np.random.default_rng(seed))


def fit(state, batches, *, task=None, epochs=1, seed=2, on_step=None, **settings):
    budget = Budget(epochs=epochs, settings=settings, on_step=on_step)
    return (task or make()).fit(batches, state=state, budget=budget, rng=np.random.default_rng(seed))


def frames(count: int = 4, **changes):
    return stereo_frames(RIG, count, **changes)


def weights_of(state):
    return {name: array for name, array in state.items() if name.startswith("model.")}


def score(state, of, task=None):
    scorer = (task or make()).begin(state=state)
    scorer.update(of)
    return scorer.scores()


# learning -------------------------------------------------------------------------------------------------


def test_every_weight_moves():
    state = start()
    fitted = weights_of(fit(state, [frames()]))
    still = [name for name, array in weights_of(state).items() if np.array_equal(array, fitted[name])]
    assert still == []


def test_it_learns_depth():
    losses: list[float] = []
    state = start()
    taught = [frames(8)]
    fitted = fit(
        state, taught, epochs=12, on_step=lambda loss: losses.append(loss["loss"]), learning_rate=5e-3
    )
    assert len(losses) == 24
    assert np.mean(losses[-4:]) < 0.5 * np.mean(losses[:4])
    unseen = frames(4, seed=77)
    assert score(fitted, unseen)["log_error"] < 0.5 * score(state, unseen)["log_error"]


def test_going_on_equals_never_having_stopped():
    whole = frames(8)
    once = fit(start(), [whole], **ALL_AT_ONCE)
    halfway = fit(start(), [batch(whole, 0, 4)], **ALL_AT_ONCE)
    assert fingerprint(fit(halfway, [batch(whole, 4, None)], **ALL_AT_ONCE)) == fingerprint(once)
    assert fingerprint(halfway) != fingerprint(once)


def test_passes_follow_one_another_as_fits_do():
    whole = [frames(4)]
    twice = fit(fit(start(), whole, **ALL_AT_ONCE), whole, **ALL_AT_ONCE)
    assert fingerprint(fit(start(), whole, epochs=2, **ALL_AT_ONCE)) == fingerprint(twice)


def test_how_frames_are_cut_into_batches_does_not_matter():
    whole = frames(7)
    cut = [batch(whole, 0, 3), batch(whole, 3, 4), batch(whole, 4, None)]
    training = {"crop_width_px": 48, "batch_size": 3}
    assert fingerprint(fit(start(), cut, **training)) == fingerprint(fit(start(), [whole], **training))


def test_chance_comes_from_the_generator_alone():
    training = {"crop_width_px": 32}
    first, again, other = (fit(start(), [frames()], seed=s, **training) for s in (2, 2, 3))
    assert fingerprint(first) == fingerprint(again)
    assert fingerprint(first) != fingerprint(other)
    assert fingerprint(start(seed=1)) == fingerprint(start(seed=1)) != fingerprint(start(seed=2))


def test_a_candidates_camera_is_what_it_is_trained_for():
    """The same network, trained on the same planes with other cameras, learns other disparities."""
    wide = fit(start(), [frames(4)], **ALL_AT_ONCE)
    other = stereo_frames(stereo_rig(width_px=64, height_px=32, focal_length_px=90.0), 4)
    assert fingerprint(fit(start(), [other], **ALL_AT_ONCE)) != fingerprint(wide)


def test_images_of_several_sizes_are_trained_on_together():
    """Pre-training mixes the cameras of a design space."""
    wider = stereo_frames(stereo_rig(width_px=80, height_px=48, focal_length_px=60.0), 3)
    fitted = fit(start(), [frames(3), wider], batch_size=3)
    assert fitted["adam.step"].max() == 2


def test_batches_without_a_disparity_to_learn_from_are_passed_over(caplog):
    state = start()
    far = frames(4, sky_rows=32)
    with caplog.at_level(logging.WARNING):
        fitted = fit(state, [far], sky=False)
    assert fingerprint(fitted) == fingerprint(state)
    warnings = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
    assert warnings == ["task.psmnet: 1 batches have no disparity between 0 and 16 px to learn from"]


def test_evaluation_draws_nothing():
    state = start()
    seen = frames()
    scorer = make().begin(state=state)
    example = next(iter(make().examples([seen])))
    np.testing.assert_array_equal(scorer.disparity_px(example), scorer.disparity_px(example))


# weights from files ---------------------------------------------------------------------------------------


def published(path, width=NARROW["width"], **more):
    network = PSMNet(16, width=width)
    torch.save(
        {"epoch": 300, "state_dict": {f"module.{k}": v for k, v in network.state_dict().items()}, **more},
        path,
    )
    return network.state_dict()


def test_a_published_checkpoint_loads_unchanged(tmp_path):
    entries = published(tmp_path / "kitti.tar")
    state = start(make(weights=str(tmp_path / "kitti.tar")))
    assert set(weights_of(state)) == {f"model.{name}" for name in entries}
    for name, tensor in entries.items():
        np.testing.assert_array_equal(state[f"model.{name}"], np.atleast_1d(tensor.numpy()))
    assert not state["adam.step"].any()


def test_one_of_full_size_too(tmp_path):
    network = PSMNet(192)
    torch.save(
        {"state_dict": {f"module.{k}": v for k, v in network.state_dict().items()}}, tmp_path / "full.tar"
    )
    state = start(make(weights=str(tmp_path / "full.tar"), width=1.0, max_disparity=192))
    last = "classif3.2.weight"
    np.testing.assert_array_equal(state[f"model.{last}"], network.state_dict()[last].numpy())


def test_weights_of_an_earlier_run(tmp_path):
    learnt = fit(start(), [frames()])
    save_file(dict(learnt), tmp_path / "designed.stereo.5.safetensors")
    state = start(make(weights=str(tmp_path / "designed.stereo.5.safetensors")))
    assert fingerprint(weights_of(state)) == fingerprint(weights_of(learnt))


def test_weights_of_another_architecture(tmp_path):
    published(tmp_path / "wide.tar", width=0.2)
    with pytest.raises(UserError, match="not those of this architecture") as caught:
        start(make(weights=str(tmp_path / "wide.tar")))
    (fault,) = caught.value.faults
    assert "firstconv.0.0.weight (6, 3, 3, 3) instead of (3, 3, 3, 3)" in fault.what
    assert fault.expected == "the 514 entries of PSMNet of width 0.1"


def test_a_file_that_is_no_checkpoint(tmp_path):
    (tmp_path / "notes.pth").write_text("not weights")
    with pytest.raises(UserError, match=r"notes\.pth is not a checkpoint"):
        start(make(weights=str(tmp_path / "notes.pth")))


@pytest.mark.parametrize(
    ("name", "reason"),
    [("absent.pth", "there is no file absent.pth"), ("kiti", "no weights 'kiti' are shipped")],
)
def test_missing_weights_show_before_anything_is_rendered(name, reason):
    with pytest.raises(UserError, match=reason):
        make(weights=name)


# what may go wrong ----------------------------------------------------------------------------------------


def spoilt(state, name: str, value: float):
    return {**state, name: np.full_like(state[name], value)}


def test_a_loss_that_is_no_number_fails_the_candidate_and_leaves_the_weights():
    state = spoilt(start(), "model.classif1.2.weight", np.nan)
    before = fingerprint(state)
    with pytest.raises(TrainingDiverged, match=r"task\.psmnet diverged: its loss is nan at step 1"):
        fit(state, [frames()])
    assert fingerprint(state) == before


def test_weights_that_the_last_step_spoilt_are_found_too():
    state = fit(start(), [frames()])
    state = spoilt(state, "adam.exp_avg.dres0.0.0.weight", np.inf)
    with pytest.raises(TrainingDiverged, match=r"diverged: dres0\.0\.0\.weight is no longer finite"):
        fit(state, [frames()])


def test_out_of_memory_halves_the_batch(monkeypatch, caplog):
    sizes, real = [], task_module.train

    def train(*args, batch_size, **kwargs):
        sizes.append(batch_size)
        if batch_size > 2:
            raise torch.OutOfMemoryError("CUDA out of memory.")
        return real(*args, batch_size=batch_size, **kwargs)

    monkeypatch.setattr(task_module, "train", train)
    with caplog.at_level(logging.WARNING):
        fitted = fit(start(), [frames()])
    assert sizes == [4, 2]
    assert "training anew with batches of 2" in caplog.text
    monkeypatch.undo()
    assert fingerprint(fitted) == fingerprint(fit(start(), [frames()], batch_size=2))


def test_half_precision_trains_about_as_well(monkeypatch):
    """Mixed precision as on a GPU, here on the CPU."""
    losses: dict[str, list[float]] = {"single": [], "half": []}
    for precision, kept in losses.items():
        if precision == "half":
            monkeypatch.setattr(
                training_module, "mixed_precision", lambda device: torch.autocast("cpu", torch.bfloat16)
            )
        state = fit(start(), [frames(8)], epochs=6, on_step=lambda loss, kept=kept: kept.append(loss["loss"]))
        assert state["model.dres0.0.0.weight"].dtype == np.float32
    assert losses["half"] != losses["single"]
    np.testing.assert_allclose(losses["half"], losses["single"], rtol=0.1)


def test_cuda_where_there_is_none(monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    with pytest.raises(UserError, match=r"device is cuda, but torch .* finds no CUDA GPU"):
        make(device="cuda")


@pytest.mark.parametrize(
    ("rig", "reason"),
    [
        (Rig(RIG.cameras[:1]), "needs two cameras"),
        (stereo_rig(width_px=64, height_px=24), "64 x 24 px are too small for stereo: 32 x 32 px are needed"),
        (stereo_rig(baseline_m=0.0), "have no baseline"),
        (stereo_rig(baseline_m=3.0, focal_length_px=1e4), "and none below 16 px can be found"),
    ],
)
def test_cameras_it_cannot_use_are_refused_before_anything_is_rendered(rig, reason):
    assert reason in make().lacks(rig)
    assert make().lacks(RIG) is None


def test_scoring_needs_weights():
    with pytest.raises(ValueError, match="begin needs a state"):
        make().begin(state=None)


@pytest.mark.parametrize(
    "settings", [{"max_disparity": 40}, {"width": 0}, {"device": "gpu"}, {"encoding": "log"}]
)
def test_settings_out_of_range(settings):
    with pytest.raises(ValueError, match=next(iter(settings))):
        PsmnetDepth.Config(**settings)
