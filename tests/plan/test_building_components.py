"""A component that cannot be built while a recipe is checked: its error passes and says whose it is."""

from __future__ import annotations

import pytest
import toy_plugin
from toy_study import toy_recipe

from tacos_framework.plan import make_plan
from tacos_framework.plugins import culprit_of


def test_an_error_of_a_constructor_names_the_component(toys, monkeypatch) -> None:
    def broken(self, config) -> None:
        raise ZeroDivisionError("nothing to divide by")

    monkeypatch.setattr(toy_plugin.WidthTask, "__init__", broken)
    with pytest.raises(ZeroDivisionError, match="nothing to divide by") as caught:
        make_plan(toy_recipe(), toys)
    culprit = culprit_of(caught.value)
    assert culprit is not None
    assert (culprit.use, culprit.doing) == ("task.toy-width", "as it is built")
