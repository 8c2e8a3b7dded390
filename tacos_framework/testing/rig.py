"""Conformance suite of rigs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from tacos_framework.contracts import RigBase, optional
from tacos_framework.testing.component import ComponentConformance, check_settings
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.values import Rig


class RigConformance(ComponentConformance):
    """The suite for rigs; give the design variables that have no default."""

    kind: ClassVar[str] = "rig"
    variables: ClassVar[Mapping[str, Any]] = {}

    def make_variables(self) -> Any:
        return self.component.Variables(**self.variables)

    def test_its_variables_are_frozen_and_documented(self) -> None:
        check_settings(self.component.Variables)

    def test_its_variables_survive_json(self) -> None:
        variables = self.make_variables()
        assert self.component.Variables.model_validate_json(variables.model_dump_json()) == variables

    def test_it_builds_the_same_rig_each_time(self) -> None:
        rig = self.make().build(self.make_variables())
        assert isinstance(rig, Rig)
        assert fingerprint(rig) == fingerprint(self.make().build(self.make_variables()))

    def test_its_cameras_have_rigid_poses(self) -> None:
        for camera in self.make().build(self.make_variables()).cameras:
            rotation = camera.agent_from_camera[:3, :3]
            np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
            assert np.linalg.det(rotation) > 0, f"camera {camera.name!r} is mirrored"
            np.testing.assert_array_equal(camera.agent_from_camera[3], [0, 0, 0, 1])

    def test_it_derives_the_quantities_it_names(self) -> None:
        derived = self.make().derived(self.make_variables())
        assert set(derived) <= set(self.component.derived_quantities)
        wrong = {name: value for name, value in derived.items() if not math.isfinite(value)}
        assert not wrong, f"derived quantities must be finite: {wrong}"

    def test_its_derived_quantities_have_units(self) -> None:
        assert all(self.component.derived_quantities.values())

    def test_its_coordinates_are_finite_numbers(self) -> None:
        """Coordinates are checked where the rig declares any (`RigBuilder.coordinates`)."""
        rig = self.make()
        if not callable(optional(rig, RigBase, "coordinates")):
            return
        found = rig.coordinates(self.make_variables())
        wrong = {name: value for name, value in found.items() if not math.isfinite(value)}
        assert found, "coordinates() names none; leave it out where derived quantities may stand for them"
        assert not wrong, f"coordinates must be finite: {wrong}"

    def test_what_it_says_beside_its_cameras_is_well_formed(self) -> None:
        bounded = {constraint.quantity for constraint in optional(self.component, RigBase, "buildable")}
        assert bounded <= set(self.component.derived_quantities)
        names = {name for group in optional(self.component, RigBase, "alternatives") for name in group}
        assert names <= set(self.component.Variables.model_fields)
        notes = getattr(self.make(), "notes", None)
        assert notes is None or all(isinstance(note, str) for note in notes(self.make_variables()))
