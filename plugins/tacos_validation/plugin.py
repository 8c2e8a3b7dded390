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
            summary="Rank agreement of a small study and the same study at full size.",
        ),
        Component(
            "procedure",
            "ablation",
            "tacos_validation.ablation.compare:Ablation",
            summary="What each step of a simulation changes in the ranking of cameras.",
        ),
        Component(
            "procedure",
            "compare-studies",
            "tacos_validation.studies_compared.compare:CompareStudies",
            summary="Variants of a study, such as joint and frozen, over several seeds.",
        ),
        Component(
            "procedure",
            "claims",
            "tacos_validation.claims.compare:ClaimsTested",
            summary="Claims, such as those of a paper, each tested by studies over many seeds.",
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
            summary="Studies of known jobs, compared with the cameras that engineers use.",
        ),
        Component(
            "procedure",
            "check-gpu",
            "tacos_validation.gpu_checked.check:CheckGpu",
            summary="Pictures of the GPU compared with those of software, and the speed of a study on it.",
        ),
        Component(
            "procedure",
            "validate-cameras",
            "tacos_validation.cameras_validated.validate:ValidateCameras",
            summary="Ranking of real cameras in simulation and reality, before and after a diagnosis.",
        ),
        Component(
            "procedure",
            "replay-exposures",
            "tacos_validation.exposures_replayed.replay:ReplayExposures",
            summary="Ranking of exposures replayed from a recording, and of the real ones.",
        ),
        Component(
            "procedure",
            "validate-task",
            "tacos_validation.task_validation.validate:ValidateTask",
            summary="The paper's second check: whether a simulator ranks cameras as a reference does.",
        ),
    ]
