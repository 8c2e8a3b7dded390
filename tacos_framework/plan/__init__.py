"""From a recipe and the installed plugins to a plan: all components found, all settings and wires checked.

==============  ========================================================================================
``plan``        what a plan is
``parts``       a component class with its checked settings
``making``      the whole recipe, section by section
``findings``    what all sections share: components found by name, and every fault with its place
``nodes``       the graph
``rig``         what builds the cameras, and which of its variables are fixed
``design``      what is free, and within which bounds
``camera_fit``  whether sensors and tasks can work with any camera the design may choose
``judging``     constraints, fitness, and the cameras off the shelf
==============  ========================================================================================
"""

from __future__ import annotations

from tacos_framework.plan.parts import Part
from tacos_framework.plan.plan import Plan
from tacos_framework.plan.planner import make_plan

__all__ = ["Part", "Plan", "make_plan"]
