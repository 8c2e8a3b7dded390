"""Running a study in a results folder: begun, gone on with, broken off, reported on."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from tacos_framework.contracts import JobRunner
from tacos_framework.plan import Plan, make_plan
from tacos_framework.plan.located import located_recipe
from tacos_framework.plugins import Plugins
from tacos_framework.plugins.executing import executor_of_run
from tacos_framework.recipe import Recipe
from tacos_framework.store import Results
from tacos_framework.store.dependencies import manifest_of_study
from tacos_framework.store.manifest import settle_manifest
from tacos_framework.study.extension import for_resuming, without_budget
from tacos_framework.study.failure_policy import KeepsFailing
from tacos_framework.study.progress import Progress, Silent
from tacos_framework.study.study import BROKEN_OFF, DEFECT, Study

log = logging.getLogger(__name__)


def run_study(
    study: Recipe | Plan,
    *,
    out: Path,
    plugins: Plugins,
    executor: JobRunner | None = None,
    resume: bool = False,
    extend: Mapping[str, int] | None = None,
    accept_changes: bool = False,
    progress: Progress | None = None,
    command: str = "",
    report: bool = True,
) -> dict[str, Any]:
    """Run a study; see `tacos_framework.run`."""
    given = study.recipe if isinstance(study, Plan) else study
    recipe = for_resuming(given, out, plugins, extend or {}) if resume else given
    plan = study if isinstance(study, Plan) and recipe is given else make_plan(recipe, plugins)
    data = located_recipe(plan)
    may_change = partial(without_budget, optimizer=plan.optimizer) if extend else dict
    results, checkpoint = (
        Results.resume(out, data, may_change) if resume else (Results.create(out, data), None)
    )
    parts = [*plan.parts.values(), plan.executor]
    packages = {part.cls.__module__.partition(".")[0] for part in parts}
    with results, results.logging({"tacos_framework", *packages}):
        manifest = settle_manifest(
            results, manifest_of_study(plan), accept_changes=accept_changes, begun=checkpoint is not None
        )
        part = plan.executor
        with executor_of_run(executor, part.make, part.use, part.distribution) as evaluates:
            running = Study(plan, plugins, results, evaluates, progress or Silent(), manifest, command)
            try:
                running.restore(checkpoint)
                running.run()
            except KeyboardInterrupt:
                running.broken_off = BROKEN_OFF
                log.warning("Interrupted. All results are kept; --resume continues.")
            except KeepsFailing as error:
                running.broken_off = f"{DEFECT}: {error}"
                log.error("%s", running.broken_off)
        result = running.finish()
        if report:
            _report(results.folder, plugins)
    return result


def _report(folder: Path, plugins: Plugins) -> None:
    """Have plugins report on the study; the result stands, whatever becomes of its report."""
    for failure in plugins.offers.write_reports(folder)[1]:
        warning = f"no report by {failure.plugin}: {failure.reason}; `tacos report` tries again"
        log.warning("%s", warning, exc_info=failure.error)
