"""The dataflow graph: typed ports, wiring, order, evaluation in batches."""

from __future__ import annotations

from tacos_framework.graph.graph import Graph
from tacos_framework.graph.signature import NODE_KINDS, Signature, signature_of
from tacos_framework.graph.wiring import Node, wiring_faults

__all__ = ["NODE_KINDS", "Graph", "Node", "Signature", "signature_of", "wiring_faults"]
