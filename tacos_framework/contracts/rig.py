"""Cameras from design variables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Protocol

from tacos_framework.settings import Settings
from tacos_framework.values import Rig


class RigBuilder(Protocol):
    """Turns design variables into cameras.

    ``Variables`` is a `Settings` class whose fields are what a recipe may design or fix; fields without a
    default must be given by the recipe, as a design variable or as a fixed value under ``rig:``.

    A further member is optional:

    ``coordinates(variables) -> Mapping[str, float]``
        What images depend on, as numbers along which they change evenly: angles, logarithms of pixel counts
        and pitch. A model of the scores learns along them what candidates have in common. Without it, the
        derived quantities and the numbers among the variables stand for them.
    """

    Config: ClassVar[type[Settings]]
    Variables: ClassVar[type[Settings]]
    derived_quantities: ClassVar[Mapping[str, str]]  # name -> unit, for constraints and reports

    def build(self, variables: Settings) -> Rig:
        """The rig for values of the variables, an instance of ``Variables``."""
        ...

    def derived(self, variables: Settings) -> Mapping[str, float]:
        """The derived quantities of these variables, cheaply: nothing is rendered."""
        ...
