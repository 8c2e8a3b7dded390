"""The dataflow graph: typed ports, wiring, order, evaluation in batches."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, get_type_hints

import networkx

from tacos_framework.errors import Fault, did_you_mean
from tacos_framework.values import Episode

_VERB = {"scene": "episode", "renderer": "capture", "sensor": "expose", "task": "begin"}
"""The kinds that can be nodes, and the verb whose signature gives their ports."""


@dataclass(frozen=True)
class Signature:
    """The ports of a component, read off the annotations of its verb.

    Parameters
    ----------
    inputs
        Input ports and their types.
    output
        Type of the output port; None for tasks, which end a path.
    supplied
        Keyword-only parameters: what the framework supplies.
    """

    inputs: Mapping[str, type[Any]]
    output: type[Any] | None
    supplied: frozenset[str]


def signature_of(cls: type[Any], kind: str) -> Signature:
    """The ports of a component class.

    Raises
    ------
    TypeError
        When a port has no annotation.
    """
    verb = getattr(cls, _VERB[kind])
    inputs, output, supplied = _ports(verb, cls)
    if kind == "task":
        if output is None or not hasattr(output, "update"):
            raise TypeError(
                f"{cls.__name__}.begin is annotated to return {output}, which has no update method"
            )
        inputs, _, _ = _ports(output.update, output)
        output = None
    return Signature(inputs, output, supplied)


def _ports(verb: Callable[..., Any], cls: type[Any]) -> tuple[dict[str, Any], Any, frozenset[str]]:
    hints = get_type_hints(verb)
    inputs, supplied = {}, set()
    for name, parameter in list(inspect.signature(verb).parameters.items())[1:]:
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY:
            supplied.add(name)
        elif name in hints:
            inputs[name] = hints[name]
        else:
            raise TypeError(f"{cls.__name__}.{verb.__name__}: port {name!r} has no type annotation")
    return inputs, hints.get("return"), frozenset(supplied)


@dataclass(frozen=True)
class Node:
    """One component in the graph.

    Parameters
    ----------
    name
        Its name in the recipe.
    kind, use
        ``"sensor"``, ``"sensor.affine-noise"``.
    signature
        Its ports.
    sources
        Which node feeds each input port.
    """

    name: str
    kind: str
    use: str
    signature: Signature
    sources: Mapping[str, str] = field(default_factory=dict)


Where = Callable[[Sequence[str]], str]
"""Turns ``(node, "in", port)`` into a place to show the user."""


def wiring_faults(nodes: Mapping[str, Node], where: Where) -> list[Fault]:
    """Everything wrong with the wiring: unknown ports and nodes, missing inputs, types, cycles, scenes."""
    faults = [fault for node in nodes.values() for fault in _port_faults(node, nodes, where)]
    links = networkx.DiGraph()
    links.add_nodes_from(nodes)
    links.add_edges_from((s, n.name) for n in nodes.values() for s in n.sources.values() if s in nodes)
    cycles = list(networkx.simple_cycles(links))
    for cycle in cycles:
        loop = " -> ".join([*cycle, cycle[0]])
        faults.append(
            Fault(
                where((cycle[0], "in")),
                f"the nodes feed each other in a circle: {loop}",
                "a path from the scene to the tasks",
                "Cut one of these connections.",
            )
        )
    if faults:
        return faults
    for node in nodes.values():
        scenes = [name for name in networkx.ancestors(links, node.name) if nodes[name].kind == "scene"]
        if len(scenes) > 1:
            faults.append(
                Fault(
                    where((node.name,)),
                    f"node {node.name!r} depends on the scenes {' and '.join(sorted(scenes))}",
                    "one scene upstream of each node",
                )
            )
        if node.kind != "task" and not any(
            nodes[n].kind == "task" for n in networkx.descendants(links, node.name)
        ):
            faults.append(
                Fault(
                    where((node.name,)),
                    f"no task uses node {node.name!r}",
                    "",
                    "Wire it to a task, or remove it.",
                )
            )
    return faults


def _port_faults(node: Node, nodes: Mapping[str, Node], where: Where) -> Iterator[Fault]:
    ports = node.signature.inputs
    for port in ports:
        if port not in node.sources:
            fitting = [n.name for n in nodes.values() if n.signature.output is ports[port]]
            example = f"in: {{{port}: {fitting[0] if fitting else 'NODE'}}}"
            yield Fault(
                where((node.name,)),
                f"port {port!r} of node {node.name!r} ({node.use}) is not wired",
                f"a node that gives {_type_name(ports[port])}",
                f"Add {example}.",
            )
    for port, source in node.sources.items():
        place = where((node.name, "in", port))
        if port not in ports:
            remedy = did_you_mean(port, ports) or f"{node.use} has no input ports: remove the wiring."
            yield Fault(place, f"node {node.name!r} ({node.use}) has no port {port!r}", "", remedy)
        elif source not in nodes:
            yield Fault(
                place, f"there is no node {source!r}", "", did_you_mean(source, set(nodes) - {node.name})
            )
        elif (given := nodes[source].signature.output) is None:
            yield Fault(
                place,
                f"node {source!r} is a task and gives nothing on",
                f"a node that gives {_type_name(ports[port])}",
            )
        elif not issubclass(given, ports[port]):
            fitting = [n.name for n in nodes.values() if n.signature.output is ports[port]]
            remedy = f"Wire it to {' or '.join(map(repr, fitting))}." if fitting else ""
            yield Fault(
                place,
                f"port {port!r} takes {_type_name(ports[port])}, but node {source!r} "
                f"({nodes[source].use}) gives {_type_name(given)}",
                "",
                remedy,
            )


def _type_name(kind: Any) -> str:
    return getattr(kind, "__name__", str(kind))


class Graph:
    """A graph whose wiring is right.

    Parameters
    ----------
    nodes
        The nodes by name.

    Raises
    ------
    ValueError
        When the wiring is wrong; `wiring_faults` tells all that is.
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

    def reached_from(self, names: Collection[str]) -> tuple[str, ...]:
        """These nodes and all that they feed, in order."""
        reached = set(names).union(*(networkx.descendants(self._links, name) for name in names))
        return tuple(name for name in self.order if name in reached)

    def stream(
        self,
        scene: str,
        episode: Episode,
        batch_frames: int,
        call: Callable[[Node, Mapping[str, Any], Episode], Any],
        tasks: Sequence[str],
    ) -> Iterator[Mapping[str, Any]]:
        """Run an episode through the graph, batch by batch.

        Parameters
        ----------
        scene
            The scene node the episode came from.
        episode
            The whole episode.
        batch_frames
            Frames in a batch.
        call
            Evaluates one node that is neither scene nor task: given the node, its inputs by port, and the
            batch, returns its output.
        tasks
            Tasks whose inputs are wanted; what none of them needs is not evaluated.

        Yields
        ------
        For each batch, ``{task: {port: value}}``. Nothing of earlier batches is kept.
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
