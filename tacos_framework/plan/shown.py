"""The truth that renderers and tasks need, and a scene may not know."""

from __future__ import annotations

from collections.abc import Mapping

from tacos_framework.contracts import SceneBase, TaskBase, optional
from tacos_framework.graph import Graph
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.values import Episode


def check_truth(findings: RecipeFindings, graph: Graph, nodes: Mapping[str, ConfiguredComponent]) -> None:
    """Renderers and tasks that need what their scene does not know are faults."""
    for name, part in nodes.items():
        node = graph.nodes[name]
        if node.kind not in ("renderer", "task"):
            continue
        scene = nodes[graph.scene_of(name)]
        absent = tuple(optional(scene.instance, SceneBase, "absent"))
        if node.kind == "renderer" and "geometry" in absent and Episode in node.signature.inputs.values():
            what = f"{part.use} draws surfaces, and {scene.use} has none"
            findings.add(
                ("nodes", name, "use"), what, "a renderer of what it gives", "Choose another renderer."
            )
        elif node.kind == "task":
            missing = [truth for truth in optional(part.cls, TaskBase, "needs") if truth in absent]
            if missing:
                what = f"{part.use} is scored by {' and '.join(missing)}, which {scene.use} does not know"
                findings.add(("nodes", name), what, "a task that needs images alone", "Leave it out.")
