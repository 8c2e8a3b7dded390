"""Which effects part a simulation from a camera."""

from tacos_gap.attribution.found import Attribution
from tacos_gap.attribution.rounds import SIMULATIONS
from tacos_gap.attribution.selection import ForwardSelection
from tacos_gap.attribution.worth import COMPLEXITY_PENALTY, LEAST_CHANGE

__all__ = ["COMPLEXITY_PENALTY", "LEAST_CHANGE", "SIMULATIONS", "Attribution", "ForwardSelection"]
