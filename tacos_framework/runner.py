"""Running a recipe of any kind: the same door for the command line and for library use."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tacos_framework import __version__
from tacos_framework.contracts import JobRunner
from tacos_framework.environment import describe_environment
from tacos_framework.errors import Fault, UserError
from tacos_framework.plan import Plan
from tacos_framework.plan.procedure import ProcedurePlan, plan_procedure
from tacos_framework.plugins import Plugins, calling
from tacos_framework.plugins.executing import executor_of_run
from tacos_framework.recipe import Recipe
from tacos_framework.recipe.procedure import ProcedureRecipe
from tacos_framework.store import RESULT, Results
from tacos_framework.store.dependencies import manifest_of_procedure
from tacos_framework.store.manifest import settle_manifest
from tacos_framework.study import run_study
from tacos_framework.study.progress import Progress, Silent


def run(
    recipe: Recipe | ProcedureRecipe | Plan | ProcedurePlan,
    *,
    out: str | Path,
    plugins: Plugins | None = None,
    executor: JobRunner | None = None,
    resume: bool = False,
    extend: Mapping[str, int] | None = None,
    accept_changes: bool = False,
    progress: Progress | None = None,
    command: str = "",
    report: bool = True,
) -> dict[str, Any]:
    """Run a recipe and leave its results in a folder.

    - `recipe`: what to do: a study or a procedure, from `load_recipe` or built in Python; or its plan, where
      it was checked already.
    - `out`: the results folder: new or empty, or with `resume` that of a run to go on with.
    - `plugins`: the plugins to use; those installed if None.
    - `executor`: evaluates instead of the recipe's executor, and is left open: for a host with workers of its
      own.
    - `resume`: go on with the run in `out`. The result equals that of an unbroken run.
    - `extend`: then go on for longer than it was begun for: by how much to raise which setting of its
      optimizer, ``{"generations": 10}``. The result equals that of a study begun with the larger number.
    - `accept_changes`: then go on although code, versions or files have changed since it was begun; the
      result says so.
    - `command`: how the run was started, for the report.
    - `report`: also have plugins report on a study (``report.html``); procedures write theirs always.

    Returns: what stands in ``result.json``.

    Raises `UserError` when the recipe, the plugins or the folder do not allow it; nothing has been computed
    then.
    """
    plugins = plugins or Plugins.discover()
    progress = progress or Silent()
    if isinstance(recipe, ProcedureRecipe | ProcedurePlan):
        if extend:
            raise UserError(Fault("extend", "only studies can be extended", "", "Leave it out."))
        return _run_procedure(recipe, Path(out), plugins, executor, resume, accept_changes, progress, command)
    return run_study(
        recipe,
        out=Path(out),
        plugins=plugins,
        executor=executor,
        resume=resume or bool(extend),
        extend=extend,
        accept_changes=accept_changes,
        progress=progress,
        command=command,
        report=report,
    )


@contextmanager
def _saying_how_to_go_on(resumable: bool) -> Iterator[None]:
    """Have Ctrl-C say what goes on with a procedure that can."""
    try:
        yield
    except KeyboardInterrupt as interrupted:
        if resumable:
            interrupted.add_note("(the same command with --resume goes on)")
        raise


def _run_procedure(
    given: ProcedureRecipe | ProcedurePlan,
    out: Path,
    plugins: Plugins,
    executor: JobRunner | None,
    resume: bool,
    accept_changes: bool,
    progress: Progress,
    command: str,
) -> dict[str, Any]:
    plan = given if isinstance(given, ProcedurePlan) else plan_procedure(given, plugins)
    recipe = plan.recipe
    if resume and "resume" not in plan.asks_for:
        raise UserError(
            Fault("--resume", f"{recipe.use} cannot go on with a broken run", "", "Start it anew.")
        )
    distribution = plugins.distribution_of(recipe.use)
    with calling(recipe.use, distribution, "as it is built"):
        procedure = plan.cls(plan.config)
    data = plan.as_data()
    resumable = "resume" in plan.asks_for
    results = Results.resume(out, data)[0] if resume else Results.create(out, data, resumable=resumable)
    supplied = {
        "out": out,
        "seed": recipe.seed,
        "plugins": plugins,
        "progress": progress,
        "resume": resume,
        "accept_changes": accept_changes,
    }
    evaluating = executor_of_run(
        executor,
        lambda: plan.executor_cls(plan.executor_config),
        plan.executor,
        plugins.distribution_of(plan.executor),
    )
    began = time.monotonic()
    with results, results.logging({"tacos_framework", plan.cls.__module__.partition(".")[0]}):
        now = manifest_of_procedure(plan, plugins)
        manifest = settle_manifest(results, now, accept_changes=accept_changes, begun=resume)
        with evaluating as evaluates:
            supplied["executor"] = evaluates
            asked = {name: value for name, value in supplied.items() if name in plan.asks_for}
            with _saying_how_to_go_on(resumable), calling(recipe.use, distribution, "run"):
                found: Mapping[str, Any] = procedure.run(**asked)
        result = {
            "tacos": __version__,
            "name": recipe.name or recipe.use,
            "procedure": recipe.use,
            "seed": recipe.seed,
            "seconds": round(time.monotonic() - began, 3),
            "environment": describe_environment(evaluates.workers, plugins.offers.findings()),
            "command": command,
            **({"accepted": manifest.accepted} if manifest.accepted else {}),
            **found,
        }
        results.write_json(RESULT, result)
    return result
