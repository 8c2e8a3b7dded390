"""Cameras from design variables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, ClassVar, Protocol

from tacos_framework.settings import Settings
from tacos_framework.values import Rig


class RigBuilder(Protocol):
    """Turns design variables into cameras.

    ``Variables`` is a `Settings` class whose fields are what a recipe may design or fix; fields without a
    default must be given by the recipe, as a design variable or as a fixed value under ``rig:``.

    Derived quantities that a missing value leaves unknown, such as the margin of an image circle that
    nobody states, are left out. Some have a meaning to the core: ``f_number_min`` is the smallest f-number of
    the lens, and no scenario may open it further; ``f_number`` is that of a lens which cannot be changed, and
    stands for that of every scenario; no exposure may be below ``exposure_min_us``; of ``frame_rate_fps``
    what exposures leave is bounded.

    `RigBase` has the optional members.
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


class RigBase:
    """Optional members of a `RigBuilder`, with their defaults."""

    buildable: ClassVar[Sequence[Any]] = ()
    """Constraints (`tacos_framework.Constraint`) without which the cameras cannot be built; they hold
    unless the recipe bounds the same quantity."""
    alternatives: ClassVar[Sequence[frozenset[str]]] = ()
    """Groups of variables of which exactly one is given, as a focal length or a lens: a product that fixes
    one of a group leaves none of the others to be designed."""
    notes: Callable[..., Iterable[str]] | None = None
    """``notes(variables)``: sentences on what somebody who builds these cameras should know."""
    coordinates: Callable[..., Mapping[str, float]] | None = None
    """``coordinates(variables)``: what images depend on, as numbers along which they change evenly: angles,
    logarithms of pixel counts and pitch. A model of the scores learns along them what candidates have in
    common. Without it, the derived quantities and the numbers among the variables stand for them."""
