"""Conformance suite of all components, whatever their kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import pytest
from pydantic import ValidationError

from tacos_framework.contracts import VERBS
from tacos_framework.settings import Settings


class ComponentConformance:
    """Inherit from the suite of a kind, and name the component; give settings where defaults are missing."""

    kind: ClassVar[str]
    component: ClassVar[type[Any]]
    config: ClassVar[Mapping[str, Any]] = {}

    def make(self) -> Any:
        """The component under test; override where it is built in another way."""
        return self.component(self.component.Config(**self.config))

    def test_it_has_the_verbs_of_its_kind(self) -> None:
        component = self.make()
        missing = [verb for verb in VERBS[self.kind] if not callable(getattr(component, verb, None))]
        assert not missing, f"a {self.kind} needs the methods {', '.join(missing)}"

    def test_its_settings_are_frozen_and_documented(self) -> None:
        check_settings(self.component.Config)

    def test_its_settings_survive_json(self) -> None:
        config = self.component.Config(**self.config)
        assert self.component.Config.model_validate_json(config.model_dump_json()) == config

    def test_it_refuses_unknown_settings(self) -> None:
        with pytest.raises(ValidationError, match="no_such_setting"):
            self.component.Config(**self.config, no_such_setting=1)


def check_settings(settings: type[Any]) -> None:
    """Assert that a Settings class is frozen, and that each field carries help and a unit."""
    name = settings.__qualname__
    assert isinstance(settings, type), f"{name} is not a class"
    assert issubclass(settings, Settings), f"{name} does not derive from tacos_framework.settings.Settings"
    assert settings.model_config.get("frozen"), f"{name} is not frozen"
    for field, info in settings.model_fields.items():
        assert info.description, f"{name}.{field} has no help; declare it with setting(..., help=...)"
        extra = info.json_schema_extra
        assert isinstance(extra, dict), f"{name}.{field} has no unit; declare it with setting(..., unit=...)"
        assert extra.get("unit"), f"{name}.{field} has no unit; declare it with setting(..., unit=...)"
