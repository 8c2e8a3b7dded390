"""Wiring: what fits is put in order, what does not is refused in a sentence."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import pytest
import toy_plugin

from tacos_framework.graph import Graph, Node, Signature, signature_of, wiring_faults
from tacos_framework.graph.types import fits
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
    assert signature_of(toy_plugin.ToyScene, "scene").output is Episode
    renderer = signature_of(toy_plugin.ToyRenderer, "renderer")
    assert renderer == Signature({"episode": Episode}, Capture, frozenset({"rig", "exposure"}), "capture")
    task = signature_of(toy_plugin.WidthTask, "task")
    assert (task.inputs, task.output) == ({"frames": FrameBatch}, None)


def test_the_ports_of_effects_and_sensors_follow_from_kind_and_stage():
    sensor = signature_of(toy_plugin.ToySensor, "sensor")
    assert (sensor.inputs, sensor.output) == ({"capture": Capture}, FrameBatch)
    for effect, port, image in (
        (toy_plugin.Dim, "capture", Capture),  # light
        (toy_plugin.Offset, "capture", Capture),  # inside the sensor
        (toy_plugin.Invert, "frames", FrameBatch),  # files
    ):
        signature = signature_of(effect, "effect")
        assert (signature.inputs, signature.output) == ({port: image}, image)


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


class Tracks:
    """A value of a plugin's own."""


class LongTracks(Tracks):
    """A better one."""


class Finder:
    def transform(self, frames: FrameBatch, *, exposure: object) -> LongTracks: ...


class Joiner:
    def transform(self, first: Tracks, second: Tracks | Capture) -> Tracks: ...


class Lister:
    def transform(self, tracks: list[Tracks]) -> FrameBatch: ...


class Judge:
    def begin(self, *, state: object) -> JudgesScorer: ...


class JudgesScorer:
    def update(self, tracks: Tracks) -> None: ...


def transform(name: str, cls: type, **sources: str) -> Node:
    return Node(name, "transform", f"transform.{name}", signature_of(cls, "transform"), sources)


def judge(**sources: str) -> Node:
    return Node("judge", "task", "task.judge", signature_of(Judge, "task"), sources)


def test_values_of_a_plugin_go_from_node_to_node_and_a_class_fits_its_bases():
    nodes = chain(
        found=transform("found", Finder, frames="frames"),
        joined=transform("joined", Joiner, first="found", second="capture"),
        judge=judge(tracks="joined"),
    )
    assert faults(nodes) == []
    assert Graph(nodes).leading_to("judge")[-4:] == ("frames", "found", "joined", "judge")
    assert Graph(nodes).reached_from(["found"]) == ("found", "joined", "judge")
    assert nodes["found"].signature.supplied == {"exposure"}


def test_values_of_a_plugin_that_do_not_fit_are_named():
    (fault,) = faults(chain(judge=judge(tracks="frames")))
    assert "port 'tracks' takes Tracks, but node 'frames' (sensor.toy) gives FrameBatch" in fault
    (fault,) = faults(
        chain(
            found=transform("found", Finder, frames="frames"),
            listed=transform("listed", Lister, tracks="found"),
            late=node("late", "task", frames="listed"),
        )
    )
    assert "takes list[" in fault
    assert "Tracks], but node 'found' (transform.found) gives LongTracks" in fault


def test_an_unwired_port_offers_what_gives_a_more_special_value():
    (fault,) = [
        f
        for f in faults(chain(found=transform("found", Finder, frames="frames"), judge=judge()))
        if "judge" in f
    ]
    assert "a node that gives Tracks" in fault
    assert "Add in: {tracks: found}." in fault


def test_what_stands_on_no_scene_is_pointed_out():
    class Source:
        def transform(self) -> Tracks: ...

    (fault,) = faults(chain(source=transform("source", Source), judge=judge(tracks="source")))[:1]
    assert "node 'source' (transform.source) depends on no scene" in fault


def test_a_verb_that_does_not_say_what_it_gives_is_no_node():
    class Silent:
        def transform(self, frames: FrameBatch): ...

    with pytest.raises(TypeError, match=r"Silent\.transform is not annotated with what it returns"):
        signature_of(Silent, "transform")


@pytest.mark.parametrize(
    ("given", "taken", "fitting"),
    [
        (int, int | None, True),
        (int | str, int, False),
        (list[int], list[int], True),
        (list[int], list, True),
        (list, list[int], False),
        (object, int, False),
        (int, object, True),
        (Any, int, True),
        (int, Any, True),
        (Annotated[bool, "x"], Annotated[int, "y"], True),
    ],
)
def test_what_fits(given, taken, fitting):
    assert fits(given, taken) is fitting
