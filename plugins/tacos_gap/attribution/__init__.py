"""Attribution: the effects that part a simulation from a camera."""

from tacos_gap.attribution.result import Attribution
from tacos_gap.attribution.rounds import affordable_simulations
from tacos_gap.attribution.selection import ForwardSelection
from tacos_gap.attribution.selection_rule import COMPLEXITY_PENALTY, LEAST_CHANGE

__all__ = ["COMPLEXITY_PENALTY", "LEAST_CHANGE", "Attribution", "ForwardSelection", "affordable_simulations"]
