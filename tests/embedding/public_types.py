"""What type checkers know of the public names; `make lint` checks it, and nothing here is run.

A line below is wrong on purpose: were a name of no known type, its comment would have nothing to ignore.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, assert_type

import tacos_framework as tacos

if TYPE_CHECKING:
    tacos.run()  # type: ignore[call-arg]
    tacos.run("recipe.yaml", out="runs/mine")  # type: ignore[arg-type]
    tacos.Plugins.discover().discovr()  # type: ignore[attr-defined]
    tacos.no_such_name()  # type: ignore[attr-defined]
    assert_type(tacos.load_recipe("headset_quick"), tacos.Recipe | tacos.ProcedureRecipe)
    assert_type(tacos.Fault("here", "this").remedy, str)
