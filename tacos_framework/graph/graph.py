"""A graph whose wiring is right: its order, and its evaluation in batches."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import networkx

from tacos_framework.graph.wiring import Node, wiring_faults
from tacos_framework.values import Episode, FrameBatch


class Graph:
    """A graph whose wiring is right.

    Raises `ValueError` when the wiring is wrong; `wiring_faults` tells all that is.
    """

    def __init__(self, nodes: Mapping[str, Node]):
        if faults := wiring_faults(nodes, ".".join):
            raise ValueError("\n".join(map(str, faults)))
        self.nodes = dict(nodes)
        self._links = networkx.DiGraph((s, n.name) for n in nodes.values() for s in n.sources.values())
        self._links.add_nodes_from(nodes)

    @cached_property
    def order(self) -> tuple[str, ...]:
        """The nodes, each after those that feed it; alphabetical where that leaves a choice."""
        return tuple(networkx.lexicographical_topological_sort(self._links))

    def of_kind(self, kind: str) -> tuple[str, ...]:
        """Names of the nodes of one kind, in order."""
        return tuple(name for name in self.order if self.nodes[name].kind == kind)

    def scene_of(self, name: str) -> str:
        """The scene upstream of a node (itself, if it is one)."""
        upstream = {name} | networkx.ancestors(self._links, name)
        return next(node for node in self.of_kind("scene") if node in upstream)

    def leading_to(self, name: str) -> tuple[str, ...]:
        """The nodes between the scene and a node, itself included, in order."""
        upstream = {name} | networkx.ancestors(self._links, name)
        return tuple(node for node in self.order if node in upstream and self.nodes[node].kind != "scene")

    def reached_from(self, names: Collection[str]) -> tuple[str, ...]:
        """These nodes and all that they feed, in order."""
        reached = set(names).union(*(networkx.descendants(self._links, name) for name in names))
        return tuple(name for name in self.order if name in reached)

    @property
    def shown(self) -> str:
        """The node whose frames a picture of the study shows: those a task takes of the first sensor."""
        sensor = self.of_kind("sensor")[0]
        taken = {source for task in self.of_kind("task") for source in self.nodes[task].sources.values()}
        behind = self.reached_from([sensor])
        frames = [n for n in behind if n in taken and self.nodes[n].signature.output is FrameBatch]
        return frames[0] if frames else sensor

    def stream(
        self,
        scene: str,
        episode: Episode,
        batch_frames: int,
        call: Callable[[Node, Mapping[str, Any], Episode], Any],
        tasks: Sequence[str],
    ) -> Iterator[Mapping[str, Any]]:
        """Run an episode through the graph, batch by batch.

        - `scene`: the scene node the episode came from.
        - `batch_frames`: frames in a batch.
        - `call`: evaluates one node that is neither scene nor task: given the node, its inputs by port, and
          the batch, returns its output.
        - `tasks`: tasks whose inputs are wanted; what none of them needs is not evaluated.

        Yields: for each batch, ``{task: {port: value}}``. Nothing of earlier batches is kept.
        """
        wanted = set(tasks).union(*(networkx.ancestors(self._links, task) for task in tasks))
        path = [
            name for name in self.order if name in wanted and self.nodes[name].kind not in ("scene", "task")
        ]
        for start in range(0, len(episode), batch_frames):
            batch = episode[start : start + batch_frames]
            values: dict[str, Any] = {scene: batch}
            for name in path:
                node = self.nodes[name]
                if self.scene_of(name) == scene:
                    values[name] = call(node, _inputs(node, values), batch)
            yield {task: _inputs(self.nodes[task], values) for task in tasks if self.scene_of(task) == scene}


def _inputs(node: Node, values: Mapping[str, Any]) -> dict[str, Any]:
    return {port: values[source] for port, source in node.sources.items()}
