"""The nodes of a recipe: their components, and how they are wired."""

from __future__ import annotations

from typing import Any

from tacos_framework.contracts import learns
from tacos_framework.graph import Graph, Node, signature_of, wiring_faults
from tacos_framework.plan.findings import Findings
from tacos_framework.plan.parts import Part
from tacos_framework.recipe import NodeUse


def find_nodes(findings: Findings) -> tuple[dict[str, Part], Graph | None]:
    """The component of each node that has a sound one, and the graph where all nodes fit together."""
    recipe = findings.recipe
    parts: dict[str, Part] = {}
    nodes: dict[str, Node] = {}
    for name, use in recipe.nodes.items():
        kind = use.use.partition(".")[0]
        if kind not in ("scene", "renderer", "sensor", "task"):
            findings.add(
                ("nodes", name, "use"),
                f"{use.use} cannot be a node",
                "a scene, renderer, sensor or task",
                {"effect": "List it under effects:.", "rig": "Put it under rig:."}.get(kind, ""),
            )
            continue
        cls = findings.component(use.use, kind, ("nodes", name))
        if cls is None:
            continue
        nodes[name] = Node(name, kind, use.use, signature_of(cls, kind), use.inputs)
        _check_training(findings, name, use, cls)
        if part := findings.configured(cls, use.use, use.settings, ("nodes", name)):
            parts[name] = part
    if len(nodes) < len(recipe.nodes):
        return parts, None
    _check_lessons(findings)
    wiring = wiring_faults(nodes, lambda path: recipe.where(("nodes", *path)))
    findings.faults.extend(wiring)
    return parts, None if wiring or not nodes else Graph(nodes)


def _check_training(findings: Findings, name: str, use: NodeUse, cls: type[Any]) -> None:
    if use.train is None:
        return
    path = ("nodes", name, "train")
    if not learns(cls):
        findings.add(path, f"{use.use} does not learn", "", "Remove train:.")
    elif (kind := getattr(cls, "Training", None)) is not None:
        findings.checked(kind, use.train.settings, path)


def _check_lessons(findings: Findings) -> None:
    """Whether there is anybody to teach where the study says how."""
    recipe = findings.recipe
    if any(use.train is not None for use in recipe.nodes.values()):
        return
    for key in ("renew_training", "train_best"):
        if getattr(recipe.study, key):
            findings.add(
                ("study", key),
                "nothing learns in this study",
                "a task with train:",
                "Give one, or remove it.",
            )
