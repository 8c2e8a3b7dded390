"""Nodes, and everything that can be wrong with their wiring."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import networkx

from tacos_framework.errors import Fault, did_you_mean
from tacos_framework.graph.signature import Signature
from tacos_framework.graph.types import fits, type_name


@dataclass(frozen=True)
class Node:
    """One component in the graph."""

    name: str
    kind: str
    use: str
    """``"sensor"``, ``"sensor.affine-noise"``."""
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
        if node.kind != "scene" and not scenes:
            faults.append(
                Fault(
                    where((node.name,)),
                    f"node {node.name!r} ({node.use}) depends on no scene",
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
            fitting = _giving(ports[port], nodes, node)
            example = f"in: {{{port}: {fitting[0] if fitting else 'NODE'}}}"
            yield Fault(
                where((node.name,)),
                f"port {port!r} of node {node.name!r} ({node.use}) is not wired",
                f"a node that gives {type_name(ports[port])}",
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
                f"a node that gives {type_name(ports[port])}",
            )
        elif not fits(given, ports[port]):
            fitting = _giving(ports[port], nodes, node)
            remedy = f"Wire it to {' or '.join(map(repr, fitting))}." if fitting else ""
            yield Fault(
                place,
                f"port {port!r} takes {type_name(ports[port])}, but node {source!r} "
                f"({nodes[source].use}) gives {type_name(given)}",
                "",
                remedy,
            )


def _giving(taken: Any, nodes: Mapping[str, Node], but: Node) -> list[str]:
    """The other nodes that give what a port takes."""
    outputs = {node.name: node.signature.output for node in nodes.values() if node is not but}
    return [name for name, given in outputs.items() if given is not None and fits(given, taken)]
