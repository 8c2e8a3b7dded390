"""Does jobs in a simulation of its own, in whatever process it is unpickled."""

from __future__ import annotations

from importlib import import_module
from typing import Any, TypeVar

from tacos_framework.plan import Plan, make_plan
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Recipe
from tacos_framework.simulation.jobs import Job
from tacos_framework.simulation.simulation import Simulation

Result = TypeVar("Result")


class Evaluator:
    """Runs jobs in a simulation of its own. Can be pickled; the simulation is built where it is first used.

    - `study`: what to simulate: a recipe, or its plan, whose components this process then uses as they were
      checked.
    - `plugins`: the host's plugins; None discovers the installed ones. Other processes discover them anew and
      register the modules that were registered by hand.
    """

    def __init__(self, study: Recipe | Plan, plugins: Plugins | None = None):
        self._plan = study if isinstance(study, Plan) else None
        self.recipe = study.recipe if isinstance(study, Plan) else study
        self._plugins = plugins
        self._modules = plugins.modules if plugins else ()
        self._simulation: Simulation | None = None

    def __call__(self, job: Job[Result]) -> Result:
        return job.run(self.simulation)

    def lost(self, job: Job[Result], reason: str) -> Result:
        """The result of a job whose worker died or hung each time it was tried."""
        return job.lost(reason)

    @property
    def plan(self) -> Plan:
        return self._plan or self.simulation.plan

    @property
    def simulation(self) -> Simulation:
        if self._simulation is None:
            plugins = self._plugins or self._discover()
            self._simulation = Simulation(
                self._plan or make_plan(self.recipe, plugins), plugins.offers.episode_store()
            )
        return self._simulation

    def _discover(self) -> Plugins:
        plugins = Plugins.discover()
        for name in self._modules:
            plugins.register(import_module(name))
        return plugins

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_plan": None, "_plugins": None, "_simulation": None}
