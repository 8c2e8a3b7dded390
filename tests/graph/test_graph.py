"""Wiring: what fits is put in order, what does not is refused in a sentence."""

from __future__ import annotations

import numpy as np
import pytest
import toy_plugin

from tacos_framework.graph import Graph, Node, Signature, signature_of, wiring_faults
from tacos_framework.randomness import generator
from tacos_framework.values import Capture, Episode, FrameBatch

CLASSES = {
    "scene": toy_plugin.ToyScene,
    "renderer": toy_plugin.ToyRenderer,
    "sensor": toy_plugin.ToySensor,
    "task": toy_plugin.WidthTask,
}


def node(name: str, kind: str, **sources: str) -> Node:
    return Node(name, kind, f"{kind}.toy", signature_of(CLASSES[kind], kind), sources)


def chain(**changes: Node | None) -> dict[str, Node]:
    nodes = {
        "world": node("world", "scene"),
        "capture": node("capture", "renderer", episode="world"),
        "frames": node("frames", "sensor", capture="capture"),
        "width": node("width", "task", frames="frames"),
    }
    nodes.update({name: changed for name, changed in changes.items() if changed})
    return {name: n for name, n in nodes.items() if name not in changes or changes[name]}


def faults(nodes):
    return [str(fault) for fault in wiring_faults(nodes, ".".join)]


def test_ports_are_read_off_the_verb():
    sensor = signature_of(toy_plugin.ToySensor, "sensor")
    assert sensor == Signature({"capture": Capture}, FrameBatch, frozenset({"rig", "exposure"}))
    assert signature_of(toy_plugin.ToyScene, "scene").output is Episode
    assert signature_of(toy_plugin.WidthTask, "task") == Signature(
        {"frames": FrameBatch}, None, frozenset({"state"})
    )


def test_a_right_graph_has_no_faults_and_an_order():
    assert faults(chain()) == []
    assert Graph(chain()).order == ("world", "capture", "frames", "width")


def test_an_unwired_port_says_who_could_feed_it():
    (fault,) = faults(chain(width=node("width", "task")))
    assert "port 'frames' of node 'width' (task.toy) is not wired" in fault
    assert "Add in: {frames: frames}." in fault


def test_wrong_types_name_both_and_who_fits():
    (fault,) = faults(chain(width=node("width", "task", frames="capture")))
    assert "width.in.frames" in fault
    assert "takes FrameBatch, but node 'capture' (renderer.toy) gives Capture" in fault
    assert "Wire it to 'frames'." in fault


def test_unknown_nodes_and_ports_name_the_nearest():
    (unknown,) = faults(chain(width=node("width", "task", frames="frame")))
    assert "there is no node 'frame'" in unknown
    assert "Did you mean 'frames'?" in unknown
    missing, port = sorted(faults(chain(width=node("width", "task", frame="frames"))), reverse=True)
    assert "no port 'frame'" in port
    assert "not wired" in missing


def test_cycles_are_shown_as_the_circle_they_are():
    class Loop:
        def transform(self, frames: FrameBatch) -> FrameBatch: ...

    signature = signature_of(Loop, "transform")
    looped = chain(
        first=Node("first", "transform", "transform.loop", signature, {"frames": "second"}),
        second=Node("second", "transform", "transform.loop", signature, {"frames": "first"}),
    )
    assert any(
        "in a circle: " in fault and "first" in fault and "second" in fault for fault in faults(looped)
    )


def test_a_node_nobody_uses_is_pointed_out():
    (fault,) = faults(chain(spare=node("spare", "sensor", capture="capture")))
    assert "no task uses node 'spare'" in fault


def test_a_task_cannot_feed_anything():
    (fault,) = faults(chain(late=node("late", "task", frames="width")))
    assert "node 'width' is a task and gives nothing on" in fault


def test_a_wrong_graph_cannot_be_built():
    with pytest.raises(ValueError, match="not wired"):
        Graph(chain(width=node("width", "task")))


@pytest.mark.parametrize("batch_frames", [1, 4, 6, 100])
def test_streaming_gives_every_frame_once_and_in_order(batch_frames):
    graph = Graph(chain())
    scene = toy_plugin.ToyScene(toy_plugin.ToyScene.Config())
    episode = scene.episode(rng=generator(1, "x"), illumination_lux=1)
    calls = []

    def call(node, inputs, batch):
        calls.append(node.name)
        return batch if node.kind == "renderer" else inputs["capture"]

    batches = list(graph.stream("world", episode, batch_frames, call, ["width"]))
    seen = np.concatenate([batch["width"]["frames"].time_s for batch in batches])
    assert np.array_equal(seen, episode.time_s)
    assert [batch["width"]["frames"].first_frame for batch in batches] == list(range(0, 6, batch_frames))
    assert calls == ["capture", "frames"] * len(batches)
