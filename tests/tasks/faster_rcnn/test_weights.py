"""Weights to start with: files, what is shipped, torchvision's own, and what is refused."""

from __future__ import annotations

from urllib.error import URLError

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save_file

from tacos_framework.errors import UserError
from tacos_framework.packaged_resources import shipped_folder

pytest.importorskip("torchvision", reason="the extra perception is not installed")

import torch
from torch import nn
from torchvision.models.detection import FasterRCNN_ResNet50_FPN_Weights, fasterrcnn_resnet50_fpn

from tacos_plugins.tasks.faster_rcnn.networks import still_norms
from tacos_plugins.tasks.faster_rcnn.task import FasterRcnn

SHIPPED = "detector_indoor_narrow"


def detector(**settings):
    return FasterRcnn(FasterRcnn.Config(**{"backbone": "narrow-fpn", "device": "cpu", **settings}))


def state_of(task, seed=1):
    return task.initial_state(rng=np.random.default_rng(seed))


def weights(state):
    return {name.removeprefix("model."): a for name, a in state.items() if name.startswith("model.")}


@pytest.mark.parametrize("precision", [np.float32, np.float16])
def test_a_file_of_weights_is_what_training_starts_with(tmp_path, precision):
    given = {
        name: array.astype(precision) if array.dtype == np.float32 else array
        for name, array in weights(state_of(detector(), seed=9)).items()
    }
    save_file(given, tmp_path / "given.safetensors")
    started = weights(state_of(detector(weights=str(tmp_path / "given.safetensors"))))
    for name, array in started.items():
        assert np.array_equal(array, given[name].astype(array.dtype).reshape(array.shape)), name


def test_a_checkpoint_of_torch_and_a_state_of_a_study_are_taken_as_well(tmp_path):
    state = state_of(detector(), seed=9)
    torch.save({name: torch.tensor(a) for name, a in weights(state).items()}, tmp_path / "given.pt")
    save_file(dict(state), tmp_path / "designed.detect.3.safetensors")
    for file in ("given.pt", "designed.detect.3.safetensors"):
        started = weights(state_of(detector(weights=str(tmp_path / file))))
        assert all(np.array_equal(started[name], array) for name, array in weights(state).items())
        assert not state_of(detector(weights=str(tmp_path / file)))["adam.step"].any()


def test_weights_of_another_detector_are_refused_with_what_differs(tmp_path):
    save_file(weights(state_of(detector(classes=("sofa",)))), tmp_path / "one_class.safetensors")
    with pytest.raises(UserError) as caught:
        state_of(detector(weights=str(tmp_path / "one_class.safetensors")))
    assert "roi_heads.box_predictor.cls_score.weight (2, 128) instead of (11, 128)" in str(caught.value)
    assert "narrow-fpn of 10 classes" in str(caught.value)


def test_what_is_no_checkpoint_or_not_there_is_refused(tmp_path):
    (tmp_path / "text.pt").write_text("not weights")
    with pytest.raises(UserError, match="not a checkpoint"):
        state_of(detector(weights=str(tmp_path / "text.pt")))
    with pytest.raises(UserError, match="there is no file"):
        detector(weights=str(tmp_path / "nothing.safetensors"))
    with pytest.raises(UserError, match=f"Did you mean '{SHIPPED}'"):
        detector(weights="detector_indoor_narow")


def test_shipped_weights_say_how_they_were_made_and_are_small():
    file = shipped_folder("catalogs") / "weights" / f"{SHIPPED}.safetensors"
    with safe_open(file, "numpy") as opened:
        about = opened.metadata()
    assert {"made_by", "seed", "recipe", "scores"} <= set(about)
    assert file.stat().st_size < 2e6
    state_of(detector(weights=SHIPPED))


def test_without_a_network_the_message_says_where_to_put_torchvision_s_file(monkeypatch):
    def no_network(*_, **__):
        raise URLError("Name or service not known")

    monkeypatch.setattr("torch.hub.download_url_to_file", no_network)
    monkeypatch.setattr("torch.hub.get_dir", lambda: "/nowhere/hub")
    monkeypatch.setattr("torch.hub.os.makedirs", lambda *_, **__: None)
    with pytest.raises(UserError) as caught:
        state_of(detector(backbone="mobilenet-v3-fpn", weights="coco"))
    said = str(caught.value)
    assert "Name or service not known" in said
    assert "/nowhere/hub/checkpoints/fasterrcnn_mobilenet_v3_large_fpn" in said
    assert "pretrain_detector" in said
    with pytest.raises(UserError, match="publishes none for narrow-fpn"):
        state_of(detector(weights="coco"))


def test_torchvision_s_weights_detect_the_same_but_for_the_classes(monkeypatch):
    """Theirs are kept but for the last layer, and batch normalisation computes what theirs computes."""
    torch.manual_seed(0)
    published = fasterrcnn_resnet50_fpn(weights=None, weights_backbone=None, num_classes=91)
    for part in published.modules():
        if isinstance(part, nn.BatchNorm2d):
            part.running_var.uniform_(1e-4, 2.0)
            part.eps = 0.0
    monkeypatch.setattr(
        FasterRCNN_ResNet50_FPN_Weights, "get_state_dict", lambda self, **_: published.state_dict()
    )
    task = detector(backbone="resnet50-fpn", weights="coco")
    model = task.begin(state=state_of(task))._model
    image = torch.rand(1, 3, 64, 64)
    with torch.no_grad():
        ours, theirs = model.backbone(image), published.eval().backbone(image)
    for level, expected in theirs.items():
        torch.testing.assert_close(ours[level], expected, rtol=1e-4, atol=1e-4 * float(expected.abs().max()))
    assert model.roi_heads.box_predictor.cls_score.out_features == 11


@pytest.mark.parametrize(
    ("backbone", "parameters"),
    [("narrow-fpn", 0.70e6), ("mobilenet-v3-fpn", 18.97e6), ("resnet50-fpn", 41.35e6)],
)
def test_detectors_have_the_size_they_should(backbone, parameters):
    model = detector(backbone=backbone)._model()
    assert sum(p.numel() for p in model.parameters()) == pytest.approx(parameters, rel=0.01)
    still_norms(model)
    assert not any(p.requires_grad for n, p in model.named_parameters() if ".bn" in n)
    anchors = model.rpn.anchor_generator
    assert anchors.num_anchors_per_location()[0] == model.rpn.head.cls_logits.out_channels
