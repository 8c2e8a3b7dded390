"""Checks of the simulator, the diagnosis and the search, listed by string: importing it is light."""

from __future__ import annotations

from tacos_framework import Component, hookimpl


@hookimpl
def tacos_components() -> list[Component]:
    return [
        Component(
            "procedure",
            "gap-blind-check",
            "tacos_validation.blind.check:GapBlindCheck",
            summary="The diagnosis, checked blind on effects withheld from it, beside simpler ways.",
        ),
        Component(
            "procedure",
            "compare-optimizers",
            "tacos_validation.optimizers_compared.compare:CompareOptimizers",
            summary="Several optimizers on one design problem: equal images, many seeds, both schemes.",
        ),
        Component(
            "procedure",
            "rank-agreement",
            "tacos_validation.rank_agreement.measure:RankAgreement",
            summary="Whether a small study ranks cameras as the same study at full size does.",
        ),
        Component(
            "procedure",
            "compare-studies",
            "tacos_validation.studies_compared.compare:CompareStudies",
            summary="Variants of a study, such as joint and frozen, over several seeds.",
        ),
        Component(
            "procedure",
            "studies-table",
            "tacos_validation.studies_table.table:StudiesTable",
            summary="Several studies and the cameras they compare with in one table.",
        ),
        Component(
            "procedure",
            "validate-noise",
            "tacos_validation.noise.validate:ValidateNoise",
            summary="The paper's first check: noise of rendered grey bars against the model.",
        ),
        Component(
            "procedure",
            "noise-over-gain",
            "tacos_validation.noise.over_gain:NoiseOverGainCheck",
            summary="Models of noise over gain against real cameras, each gain left out.",
        ),
        Component(
            "procedure",
            "known-answers",
            "tacos_validation.known_answers.answers:KnownAnswers",
            summary="Whether studies of known jobs find what engineers use for them.",
        ),
        Component(
            "procedure",
            "check-gpu",
            "tacos_validation.gpu_checked.check:CheckGpu",
            summary="Whether the GPU renders what software renders, and how fast a study goes on it.",
        ),
        Component(
            "procedure",
            "validate-cameras",
            "tacos_validation.cameras_validated.validate:ValidateCameras",
            summary="Whether a simulator ranks real cameras as reality does, before and after a diagnosis.",
        ),
        Component(
            "procedure",
            "replay-exposures",
            "tacos_validation.exposures_replayed.replay:ReplayExposures",
            summary="Whether exposures replayed from a recording rank as the real ones do.",
        ),
        Component(
            "procedure",
            "validate-task",
            "tacos_validation.task_validation.validate:ValidateTask",
            summary="The paper's second check: whether a simulator ranks cameras as a reference does.",
        ),
    ]
