"""Conformance suite of transforms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from tacos_framework.graph import signature_of
from tacos_framework.graph.types import fits
from tacos_framework.testing.call import supplied
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.samples import sample_capture, sample_exposure, sample_frames, sample_rig
from tacos_framework.values import Capture, FrameBatch


class TransformConformance(ComponentConformance):
    """The suite for transforms; override `inputs` for one that takes values of a plugin's own.

    What a transform gives is compared bit by bit, so it should be a dataclass of arrays and plain values, as
    the values of the framework are.
    """

    kind: ClassVar[str] = "transform"

    def inputs(self, frames: int = 4) -> Mapping[str, Any]:
        """A value for each port, of that many consecutive frames."""
        rig = sample_rig("left", "right", width_px=160, height_px=120)
        samples = {Capture: sample_capture(rig, frames), FrameBatch: sample_frames(rig, frames)}
        ports = signature_of(self.component, "transform").inputs
        return {port: samples[taken] for port, taken in ports.items()}

    def transformed(self, inputs: Mapping[str, Any], component: Any = None) -> Any:
        """Output of a new instance, or of `component`."""
        made = component or self.make()
        asked = supplied(
            made.transform,
            rig=sample_rig("left", "right", width_px=160, height_px=120),
            exposure=sample_exposure(),
            rng=np.random.default_rng(1),
            illumination_lux=20.0,
            memory={},
        )
        return made.transform(**inputs, **asked)

    def test_its_ports_have_types(self) -> None:
        signature = signature_of(self.component, "transform")
        assert signature.inputs, "a transform has at least one input port"
        known = {"rig", "exposure", "rng", "illumination_lux", "memory"}
        assert signature.supplied <= known, f"it asks for {', '.join(signature.supplied - known)}"

    def test_it_gives_what_it_says(self) -> None:
        given = type(self.transformed(self.inputs()))
        assert fits(given, signature_of(self.component, "transform").output)

    def test_equal_inputs_and_generators_give_equal_outputs(self) -> None:
        inputs = self.inputs()
        assert fingerprint(self.transformed(inputs)) == fingerprint(self.transformed(inputs))

    def test_it_leaves_its_inputs_as_they_were(self) -> None:
        inputs = self.inputs()
        before = fingerprint(inputs)
        self.transformed(inputs)
        assert fingerprint(inputs) == before

    def test_it_keeps_nothing_of_its_own_between_calls(self) -> None:
        """Memory from frame to frame belongs into `memory`, which each episode has anew."""
        inputs, component = self.inputs(), self.make()
        self.transformed(self.inputs(frames=2), component)
        assert fingerprint(self.transformed(inputs, component)) == fingerprint(self.transformed(inputs))

    def test_it_takes_frames_one_by_one(self) -> None:
        self.transformed(self.inputs(frames=1))
