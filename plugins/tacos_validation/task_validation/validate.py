"""The paper's second check of its simulator: whether it ranks cameras at a task as reality does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import model_validator

from tacos_framework import (
    Episode,
    Fault,
    OffTheShelf,
    Plugins,
    Progress,
    Rig,
    Settings,
    Use,
    UserError,
    did_you_mean,
    generator,
    load_cameras,
    setting,
)
from tacos_plugins.building import build, build_rig, episode_of
from tacos_plugins.noise_calibration.bench import CameraSetting
from tacos_validation.harness import leave
from tacos_validation.task_validation.acquisition import Taken, take
from tacos_validation.task_validation.findings import ValidationFindings
from tacos_validation.task_validation.pages import page, summary

SIMULATORS = ("simulator", "reference")


class ValidateTask:
    """Scores cameras at a task on one target, in a simulator and in another that stands for reality.

    The camera is put before the target at one place after another, and each pair of neighbouring frames is
    scored by itself. Each place is rendered once by either simulator; frames of it are taken many times with
    fresh noise, so that what noise alone does to a ranking is known. Per pair of places and over all of them
    the cameras are ranked by the mean score, and the rankings compared (Kendall's tau), beside what a
    ranking agrees with itself under other noise.

    What stands for reality here is a path tracer: it checks what a rasterizer leaves out of the light, not
    the optics, the sensor or the target, which both share.

    Source: The paper, Sec. 4.1 (Perception Task Performance) with Fig. 3b, and the supplement, Additional
    Details on Simulator Validation: ORB features of three cameras, ten places along a line, no motion blur.
    """

    class Config(Settings):
        scene: Use = setting(
            Use(use="scene.relief-target"), help="The target, with a frame from each place of the camera."
        )
        illumination_lux: float = setting(2000.0, help="Illuminance on the target.", unit="lux", gt=0)
        simulator: Use = setting(Use(use="renderer.moderngl"), help="The renderer to validate.")
        reference: Use = setting(Use(use="renderer.mitsuba"), help="The renderer that stands for reality.")
        cameras: tuple[str, ...] = setting(
            ("oak_d_pro_wide", "flea3", "basler_dart"), help="Names in the catalog of cameras.", min_length=2
        )
        catalog: str = setting(
            "cameras", help="Name of a shipped catalog of cameras, or a path.", is_path=True
        )
        fixed: dict[str, Any] = setting(
            {}, help="Settings and variables of the rig that the cameras leave free, e.g. {binning: 4}."
        )
        sensor: Use = setting(Use(use="sensor.affine-noise"), help="The sensor model of all cameras.")
        task: Use = setting(Use(use="task.orb-features"), help="The task; one that does not learn.")
        score: str = setting("inliers", help="The score to rank by, higher is better.")
        exposures: tuple[CameraSetting, ...] = setting(
            (CameraSetting(exposure_ms=30, gain_db=15),), help="Exposure of the target.", min_length=1
        )
        seeds: int = setting(20, help="Frames with independent noise, of each place.", ge=2, le=10_000)

        @model_validator(mode="after")
        def _differ(self) -> ValidateTask.Config:
            if len({each.f_number for each in self.exposures}) > 1:
                raise ValueError("exposures share one f_number: light is rendered once for all of them")
            return self

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Progress) -> Mapping[str, Any]:
        config = self.config
        cameras = load_cameras(config.cameras, config.catalog)
        rigs = [self._rig(camera, plugins) for camera in cameras]
        scene = build(config.scene, "scene", plugins)
        rng = generator(seed, "validate-task", "scene")
        episode = episode_of(scene, rng=rng, illumination_lux=config.illumination_lux)
        self._check_task(episode, plugins)
        progress.phase("rendering and scoring", len(cameras) * len(SIMULATORS) * len(episode))
        taken = {
            simulator: [
                self._take(simulator, camera, rig, episode, seed, plugins, progress)
                for camera, rig in zip(cameras, rigs, strict=True)
            ]
            for simulator in SIMULATORS
        }
        findings = ValidationFindings(
            cameras=tuple(camera.name for camera in cameras),
            titles=tuple(camera.title for camera in cameras),
            score=config.score,
            exposures=tuple(str(each) for each in config.exposures),
            simulated=tuple(taken["simulator"]),
            reference=tuple(taken["reference"]),
        )
        shown = page(config.simulator.use, config.reference.use, findings)
        return leave(out, shown, findings.as_data(), summary(findings))

    def _rig(self, camera: OffTheShelf, plugins: Plugins) -> Rig:
        return build_rig(
            Use.model_validate({"use": camera.rig, **self.config.fixed, **camera.fixes}), plugins
        )

    def _check_task(self, episode: Episode, plugins: Plugins) -> None:
        faults = []
        task = plugins.resolve(self.config.task.use, "task", where="task")
        if self.config.score not in task.scores:
            faults.append(
                Fault(
                    "score",
                    f"{self.config.task.use} has no score {self.config.score!r}",
                    remedy=did_you_mean(self.config.score, task.scores),
                )
            )
        if len(episode) < 2:
            faults.append(
                Fault(
                    "scene",
                    f"{self.config.scene.use} gives {len(episode)} frame",
                    "two or more, from different places",
                    "Raise its frames.",
                )
            )
        if faults:
            raise UserError(faults)

    def _take(
        self,
        simulator: str,
        camera: OffTheShelf,
        rig: Rig,
        episode: Episode,
        seed: int,
        plugins: Plugins,
        progress: Progress,
    ) -> Taken:
        config = self.config
        places = iter(range(1, len(episode) + 1))
        taken = take(
            episode,
            rig,
            build(config.simulator if simulator == "simulator" else config.reference, "renderer", plugins),
            build(config.sensor, "sensor", plugins),
            build(config.task, "task", plugins),
            [each.as_exposure() for each in config.exposures],
            seed=seed,
            seeds=config.seeds,
            names=("validate-task", simulator, camera.name),
            rendered=lambda: progress.step(f"{camera.title}, {simulator}, place {next(places)}"),
        )
        if np.isnan(taken.scores[config.score]).any():
            raise UserError(
                Fault(
                    "task",
                    f"{config.task.use} has no {config.score} for two neighbouring frames",
                    "a task that scores two frames",
                )
            )
        return taken
