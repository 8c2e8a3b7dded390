"""What most users need from Python, under one name: ``import tacos``.

``design`` and ``diagnose`` run a study or a diagnosis in one call and give its results as data frames.
``run`` and ``load_recipe`` do what ``tacos-run`` does, ``read_result`` and ``read_diagnosis`` read what came
out, ``plot`` draws figures of that, and ``render`` gives frames in one line. What plugins need besides is in
`tacos_framework`.

>>> import tacos
>>> tacos.load_recipe("headset_quick").name
'headset, quick'
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tacos import plot as plot
    from tacos.one_call import design as design
    from tacos.one_call import diagnose as diagnose
    from tacos_decision import read_result as read_result
    from tacos_framework import Fault as Fault
    from tacos_framework import Plugins as Plugins
    from tacos_framework import Recipe as Recipe
    from tacos_framework import UserError as UserError
    from tacos_framework import __version__ as __version__
    from tacos_framework import load_recipe as load_recipe
    from tacos_framework import run as run
    from tacos_gap.report.result_tables import read_diagnosis as read_diagnosis
    from tacos_view import render as render
    from tacos_view.notebook import load_ipython_extension as load_ipython_extension

_HOMES = {
    "tacos_framework": "Fault Plugins Recipe UserError __version__ load_recipe run",
    "tacos.one_call": "design diagnose",
    "tacos_decision": "read_result",
    "tacos_gap.report.result_tables": "read_diagnosis",
    "tacos_view": "render",
    "tacos_view.notebook": "load_ipython_extension",
}
"""Module -> the names taken from it, which are imported on first use."""

_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = [*_HOME_OF, "plot"]  # noqa: PLE0604 - all of them are text


if not TYPE_CHECKING:  # what is not above is an error to type checkers

    def __getattr__(name: str) -> Any:
        """Import names on first use, so that importing the package costs nothing."""
        if name == "plot":
            return import_module("tacos.plot")
        if name not in _HOME_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
