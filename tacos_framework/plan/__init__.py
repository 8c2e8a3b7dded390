"""From a recipe and the installed plugins to a plan: all components found, all settings and wires checked.

==============  ========================================================================================
``plan``        what a plan is
``component``   a component class with its checked settings
``planner``     the whole recipe, section by section
``located``     the resolved recipe, with files that are found from any folder
``findings``    what all sections share: components found by name, and every fault with its place
``nodes``       the graph
``effects``     the effects, their names and cameras
``exposure``    what controls the exposure
``rig``         what builds the cameras, and which of its variables are fixed
``design``      what is free, and within which bounds
``targets``     what a design variable's name says it sets
``settable``    whether there is such a setting, and whether it takes the values
``other_keys``  where else a setting of a name that is unknown is to be found
``shown``       truth that renderers and tasks need, and a scene may not know
``starting``    settings that are given only as design variables
``cameras``     whether the cameras named are those of the rig
``camera_fit``  whether sensors and tasks can work with any camera the design may choose
``checks``      scenarios, fitness, and the cameras off the shelf
``bounded``     what constraints bound and objectives aim at
``feasibility`` whether any camera keeps the constraints
``notes``       what nobody knows about parts that keep them, and which products do not
``origins``     which figures of parts are known, and which assumed
``conditions``  what is simulated, in a sentence
``units``       figures that are probably in another unit
``procedure``   recipes that are no study
==============  ========================================================================================
"""

from __future__ import annotations

from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.plan import REFUSED, Plan
from tacos_framework.plan.planner import make_plan
from tacos_framework.plan.procedure import plan_procedure
from tacos_framework.plan.targets import EXPOSURE, Target, target_of

__all__ = [
    "EXPOSURE",
    "REFUSED",
    "ConfiguredComponent",
    "EffectPart",
    "Plan",
    "Target",
    "make_plan",
    "plan_procedure",
    "target_of",
]
