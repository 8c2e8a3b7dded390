"""The nodes of a recipe: their components, and how they are wired."""

from __future__ import annotations

from typing import Any

from tacos_framework.components import KINDS
from tacos_framework.contracts import TrainableBase, learns, optional
from tacos_framework.graph import NODE_KINDS, Graph, Node, Signature, signature_of, wiring_faults
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.starting import with_starting_values
from tacos_framework.plan.targets import EXPOSURE
from tacos_framework.recipe import NodeUse

_NO_NODES = {
    "rig": "Put it under rig:.",
    "control": "Put it under exposure:.",
    "optimizer": "Put it under optimizer:.",
    "executor": "Put it under executor:.",
    "procedure": "A procedure has a recipe of its own, with this at its top.",
}
"""Kinds that cannot be nodes, and where they stand instead."""

_RESERVED = {
    "effects": "the effects of the recipe",
    "scenario": "the scenario",
    EXPOSURE: "the exposure control",
}
"""Names under which design variables mean something else."""


def find_nodes(findings: RecipeFindings) -> tuple[dict[str, ConfiguredComponent], Graph | None]:
    """The component of each node that has a sound one, and the graph where all nodes fit together."""
    recipe = findings.recipe
    parts: dict[str, ConfiguredComponent] = {}
    nodes: dict[str, Node] = {}
    for name, use in recipe.nodes.items():
        if name in _RESERVED:
            what = f"a node is called {name!r}, which under design: means {_RESERVED[name]}"
            findings.add(("nodes", name), what, "another name")
        kind = use.use.partition(".")[0]
        if kind in _NO_NODES:
            expected = f"a {', '.join(NODE_KINDS[:-1])} or {NODE_KINDS[-1]}"
            findings.add(("nodes", name, "use"), f"{use.use} cannot be a node", expected, _NO_NODES[kind])
            continue
        cls = findings.component(use.use, kind if kind in KINDS else None, ("nodes", name))
        if cls is None or (signature := _signature(findings, name, cls, kind)) is None:
            continue
        nodes[name] = Node(name, kind, use.use, signature, use.inputs)
        _check_training(findings, name, use, cls, signature)
        if part := _part(findings, name, use, cls):
            parts[name] = part
            _check_frozen_weights(findings, name, use, part)
    if len(nodes) < len(recipe.nodes) or _some_left_out(findings):
        return parts, None
    _check_study_training(findings)
    wiring = wiring_faults(nodes, lambda path: recipe.where(("nodes", *path)))
    findings.faults.extend(wiring)
    return parts, None if wiring or not nodes else Graph(nodes)


def _some_left_out(findings: RecipeFindings) -> bool:
    """True if nodes of the recipe's text are faulty, which breaks wires to them as well."""
    return len(findings.recipe.keys_of("nodes")) > len(findings.recipe.nodes)


def _signature(findings: RecipeFindings, name: str, cls: type[Any], kind: str) -> Signature | None:
    try:
        return signature_of(cls, kind)
    except (TypeError, NameError) as error:
        findings.add(("nodes", name, "use"), f"its ports cannot be read: {error}", "", "Correct the plugin.")
        return None


def _part(findings: RecipeFindings, name: str, use: NodeUse, cls: type[Any]) -> ConfiguredComponent | None:
    """The component of a node; an effect may act on some cameras only."""
    path = ("nodes", name)
    settings = with_starting_values(findings.recipe, "node", name, cls, use.settings)
    if use.use.partition(".")[0] != "effect":
        return findings.configured(cls, use.use, settings, path)
    cameras = findings.cameras(settings.pop("cameras", None), path)
    part = findings.configured(cls, use.use, settings, path)
    if part is None:
        return None
    return EffectPart(part.use, part.cls, part.config, part.distribution, part.built, name, cameras)


def _check_training(
    findings: RecipeFindings, name: str, use: NodeUse, cls: type[Any], signature: Signature
) -> None:
    if use.train is None:
        return
    path = ("nodes", name, "train")
    if not learns(cls):
        findings.add(path, f"{use.use} does not learn", "", "Remove train:.")
    elif len(signature.inputs) != 1:
        ports = ", ".join(signature.inputs)
        findings.add(path, f"{use.use} has the ports {ports}", "one port, for what learns in a study")
    elif (kind := optional(cls, TrainableBase, "Training")) is not None:
        findings.checked(kind, use.train.settings, path)


def _check_frozen_weights(
    findings: RecipeFindings, name: str, use: NodeUse, part: ConfiguredComponent
) -> None:
    """Untrained frozen weights are reported: their scores are noise."""
    if use.train is None or use.train.weights != "frozen":
        return
    untrained = optional(part.instance, TrainableBase, "untrained")
    if callable(untrained) and (reason := untrained()):
        findings.add(
            ("nodes", name, "train", "weights"),
            f"frozen weights of {use.use} that were never trained: {reason}",
            "weights that were trained before",
            "Name such weights in the task's settings, or let it learn: weights: shared.",
        )


def _check_study_training(findings: RecipeFindings) -> None:
    """A task that the study trains has to be trainable."""
    recipe = findings.recipe
    if any(use.train is not None for use in recipe.nodes.values()):
        return
    for key in ("renew_training", "train_best"):
        if getattr(recipe.study, key):
            findings.add(
                ("study", key),
                "no task is trained in this study",
                "a task with train:",
                "Give one, or remove it.",
            )
