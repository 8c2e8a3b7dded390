"""Validating at a task: the statistics of rankings, the procedure in small, and what is refused."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.stats import kendalltau

from tacos_framework.components import Component
from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.settings import Settings, setting
from tacos_framework.study.progress import Silent
from tacos_framework.values import Capture, Episode, Exposure, FrameBatch, Rig, View
from tacos_validation.task_validation.agreement import (
    kendall,
    level_agreement,
    over_seeds,
    rank_agreement,
    separations,
    within,
)
from tacos_validation.task_validation.validate import ValidateTask


class Glow:
    """Light that depends on the camera alone: wider fields of view see more of it, or less."""

    class Config(Settings):
        per_deg: float = setting(1.0, help="Luminance per degree of field of view.", unit="cd/m2")
        at_90_deg: float = setting(200.0, help="Luminance a camera of 90 degrees sees.", unit="cd/m2")

    captured: ClassVar[int] = 0

    def __init__(self, config: Config) -> None:
        self.config = config

    def capture(self, episode: Episode, *, rig: Rig, exposure: Exposure) -> Capture:
        Glow.captured += 1
        camera = rig.cameras[0]
        shape = (len(episode), camera.height_px, camera.width_px)
        light = self.config.at_90_deg + self.config.per_deg * (camera.hfov_deg - 90)
        poses = np.tile(np.eye(4), (len(episode), 1, 1))
        view = View(
            camera, poses, np.full((*shape, 3), light, np.float32), np.ones(shape, np.float32),
            np.ones(shape, np.int32),
        )  # fmt: skip
        return Capture(episode, (view,))


class Brightness:
    """Scores frames by their mean, from the second one on."""

    class Config(Settings):
        """No settings."""

    scores: ClassVar[tuple[str, ...]] = ("dn",)

    def __init__(self, config: Config) -> None:
        self.config = config

    def begin(self, *, state: Any) -> BrightnessScorer:
        return BrightnessScorer()


class BrightnessScorer:
    """Needs two frames, of neighbouring places."""

    def __init__(self) -> None:
        self.frames: list[FrameBatch] = []

    def update(self, frames: FrameBatch) -> None:
        self.frames.append(frames)

    def scores(self) -> dict[str, float]:
        first, second = (batch.capture.episode.first_frame for batch in self.frames)
        assert second == first + 1
        return {"dn": float(np.mean([batch.images[0].mean() for batch in self.frames]))}


class Offered:
    """A plugin of the above."""

    @staticmethod
    @hookimpl
    def tacos_components() -> Sequence[Component]:
        return [
            Component("renderer", "glow", f"{__name__}:Glow", summary="Test."),
            Component("task", "brightness", f"{__name__}:Brightness", summary="Test."),
        ]


SCENE = {"use": "scene.textured-target", "texture_px": 64, "speed_m_s": 0.1, "frames": 4}
SMALL = {
    "scene": SCENE,
    "simulator": {"use": "renderer.glow"},
    "reference": {"use": "renderer.glow"},
    "fixed": {"binning": 100},
    "sensor": {"use": "sensor.affine-noise", "responsivity_dn_per_lux_s": 30},
    "task": {"use": "task.brightness"},
    "score": "dn",
    "seeds": 4,
}


def validate(out: Path, **config: Any) -> dict[str, Any]:
    plugins = Plugins.discover()
    plugins.register(Offered, name="offered")
    procedure = ValidateTask(ValidateTask.Config(**{**SMALL, **config}))
    return dict(procedure.run(out=out, seed=1, plugins=plugins, progress=Silent()))


# statistics of rankings -------------------------------------------------------------------------------------


def test_equal_orders_agree_and_reversed_ones_disagree():
    scores = np.array([[1.0, 2.0, 3.0], [10.0, 30.0, 40.0]])
    assert rank_agreement(scores, 5 * scores + 2).tau.mean == 1.0
    assert rank_agreement(scores, 5 * scores + 2).same == 1.0
    assert rank_agreement(scores, -scores).tau.mean == -1.0
    assert rank_agreement(scores, -scores).same == 0.0


def test_an_interval_holds_the_seeds_that_disagree():
    ours = np.tile([1.0, 2.0, 3.0], (20, 1))
    theirs = ours.copy()
    theirs[:10] = [2.0, 1.0, 3.0]  # one of three pairs swapped: tau 1/3
    found = rank_agreement(ours, theirs)
    assert found.same == 0.5
    assert found.tau.mean == pytest.approx(2 / 3)
    assert (found.tau.low, found.tau.high) == pytest.approx((1 / 3, 1.0))


def test_a_score_that_never_changes_tells_nothing():
    flat, rising = np.ones((3, 4)), np.tile(np.arange(4.0), (3, 1))
    assert rank_agreement(flat, rising).tau.mean == 0.0
    assert rank_agreement(flat, flat).tau.mean == 1.0
    assert level_agreement(flat, rising).mean == 0.0


def test_what_noise_allows_is_less_where_noise_swaps_neighbours():
    rng = np.random.default_rng(1)
    apart, near = np.array([0.0, 10.0, 20.0]), np.array([0.0, 0.1, 20.0])
    noise = rng.standard_normal((200, 3))
    assert within(apart + noise).tau.mean == 1.0
    assert 0.5 < within(near + noise).tau.mean < 0.8


def test_neighbours_are_named_from_the_best_with_their_distance():
    noise = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    found = separations(np.array([5.0, 9.0, 1.0]) + noise)
    assert [(better, worse) for better, worse, _ in found] == [(1, 0), (0, 2)]
    assert found[0][2] == pytest.approx(4 / np.sqrt(2))


def test_figures_of_hundreds_are_shown_whole():
    assert str(over_seeds([711.6, 711.6])) == "712 [712, 712]"
    assert str(over_seeds([0.25])) == "0.25 [0.25, 0.25]"


# the procedure ----------------------------------------------------------------------------------------------


def test_a_faithful_simulator_ranks_alike_and_a_perverse_one_in_reverse(tmp_path):
    alike = validate(tmp_path)
    assert alike["exposures"][0]["overall"]["tau"]["mean"] == 1.0
    assert alike["exposures"][0]["order"]["simulator"] == ["oak_d_pro_wide", "flea3", "basler_dart"]
    assert "Both simulators rank the cameras alike" in alike["summary"]
    perverse = validate(tmp_path, simulator={"use": "renderer.glow", "per_deg": -1.0})
    assert perverse["exposures"][0]["overall"]["tau"]["mean"] == -1.0
    assert perverse["exposures"][0]["per_pair"]["mean"] == -1.0
    assert perverse["exposures"][0]["order"]["simulator"] == ["basler_dart", "flea3", "oak_d_pro_wide"]
    assert "alike under 0 of 1 exposures" in perverse["summary"]
    assert perverse["everything_floor"]["tau"]["mean"] == 1.0


def test_light_is_rendered_once_for_all_exposures_and_seeds(tmp_path):
    before = Glow.captured
    exposures = [{"exposure_ms": 30, "gain_db": 15}, {"exposure_ms": 3, "gain_db": 35}]
    result = validate(tmp_path, exposures=exposures, seeds=3)
    assert Glow.captured - before == 2 * 3 * 4  # simulators, cameras, places
    assert [each["exposure"] for each in result["exposures"]] == ["30 ms, 15 dB", "3 ms, 35 dB"]
    assert len(result["exposures"][0]["pairs"]) == 3


def test_noise_differs_from_seed_to_seed_and_from_simulator_to_simulator(tmp_path):
    noisy = {"exposures": [{"exposure_ms": 0.95, "gain_db": 45}], "fixed": {"binning": 40}}
    level = validate(tmp_path, **noisy)["exposures"][0]["scores"]["flea3"]["dn"]
    assert level["simulator"]["low"] < level["simulator"]["high"]
    assert level["simulator"]["mean"] != level["reference"]["mean"]
    assert level["simulator"]["mean"] == pytest.approx(level["reference"]["mean"], rel=0.01)


def test_the_report_shows_figures_and_frames(tmp_path):
    validate(tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert page.count("<svg") == 2, "once more for phones"
    assert page.count("data:image/png") == 2 * 3
    assert "FLIR Flea3" in page


def test_what_cannot_be_ranked_is_refused_before_anything_is_rendered(tmp_path):
    before = Glow.captured
    with pytest.raises(UserError) as raised:
        validate(tmp_path, score="brightness", scene={**SCENE, "frames": 1})
    assert [fault.where for fault in raised.value.faults] == ["score", "scene"]
    with pytest.raises(UserError, match="no camera 'flea'"):
        validate(tmp_path, cameras=["flea", "oak_d_pro_wide"])
    assert Glow.captured == before


def test_exposures_of_different_apertures_are_refused():
    exposures = [{"exposure_ms": 30, "gain_db": 15}, {"exposure_ms": 30, "gain_db": 15, "f_number": 4}]
    with pytest.raises(ValidationError, match="share one f_number"):
        ValidateTask.Config(exposures=exposures)


@pytest.mark.gl
def test_the_rasterizer_and_the_path_tracer_rank_two_cameras_alike(tmp_path):
    pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")
    result = validate(
        tmp_path,
        scene={"use": "scene.relief-target", "blocks": 3, "texture_px": 512, "frames": 2},
        simulator={"use": "renderer.moderngl"},
        reference={"use": "renderer.mitsuba", "samples": 16, "sampler": "low-discrepancy"},
        cameras=["flea3", "basler_dart"],
        fixed={"binning": 16},
        sensor={"use": "sensor.affine-noise", "responsivity_dn_per_lux_s": 68},
        task={"use": "task.orb-features", "scale_with_binning": []},
        score="inliers",
        seeds=2,
    )
    assert result["exposures"][0]["order"]["simulator"] == ["flea3", "basler_dart"]
    assert result["exposures"][0]["overall"]["tau"]["mean"] == 1.0
    assert all(0.95 < ratio < 1.05 for ratio in result["luminance_ratio"].values())


def test_kendall_is_scipys_tau_b_with_ties() -> None:
    rng = np.random.default_rng(3)
    first, second = rng.integers(0, 4, (2, 50, 5)).astype(float)
    wanted = [kendalltau(a, b)[0] for a, b in zip(first, second, strict=True)]
    told = np.isfinite(wanted)
    assert kendall(first, second)[told] == pytest.approx(np.array(wanted)[told])
