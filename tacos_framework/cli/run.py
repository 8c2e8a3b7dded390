"""``tacos-run RECIPE``: run a recipe."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tacos_framework import __version__
from tacos_framework.cli.exits import DONE, FAILED, INTERRUPTED, ended_by_sigterm, exit_status
from tacos_framework.cli.summary import summary
from tacos_framework.environment import DEVICE_VARIABLE
from tacos_framework.errors import Fault, UserError
from tacos_framework.recipe.run_folder import RUN_RECIPE

if TYPE_CHECKING:
    from tacos_framework.plan import Plan
    from tacos_framework.plan.procedure import ProcedurePlan
    from tacos_framework.plugins import Plugins
    from tacos_framework.recipe import Recipe
    from tacos_framework.recipe.procedure import ProcedureRecipe


def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tacos-run",
        description="Run a recipe: design a camera in simulation, or calibrate, validate, diagnose.",
        epilog="Exit status: 0 done, 2 wrong input, 130 interrupted, 1 anything else.",
    )
    parser.add_argument("--version", action="version", version=f"tacos-framework {__version__}")
    parser.add_argument(
        "recipe",
        metavar="RECIPE",
        help="path of a YAML file, or name of a shipped recipe; with --resume or --extend also the folder "
        "of a run",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="sets",
        help="set a key of the recipe, dotted; repeatable",
    )
    parser.add_argument(
        "--with",
        metavar="FILE",
        dest="effects",
        action="append",
        default=[],
        help="add the effects listed in a YAML file; repeatable",
    )
    parser.add_argument("--out", metavar="DIR", type=Path, help="results folder [runs/RECIPE-TIME]")
    parser.add_argument("--seed", metavar="N", type=int, help="seed, instead of the recipe's")
    parser.add_argument("--resume", action="store_true", help="go on with the run in --out")
    parser.add_argument(
        "--extend",
        action="append",
        default=[],
        metavar="KEY=N",
        help="go on with the run in --out for N more, as in generations=10; a setting of its optimizer",
    )
    parser.add_argument(
        "--accept-changes",
        action="store_true",
        help="go on although code, versions or files have changed since the run began; results say so",
    )
    parser.add_argument("--workers", metavar="N", type=int, help="evaluate in N processes")
    parser.add_argument("--executor", metavar="NAME", help="executor component, executor.NAME")
    parser.add_argument("--device", metavar="N", type=_device, help="GPU to compute and render on, or cpu")
    parser.add_argument("--check", action="store_true", help="report all faults of the recipe, then stop")
    parser.add_argument(
        "--explain", action="store_true", help="show the resolved graph and settings, then stop"
    )
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    parser.add_argument(
        "--verbose",
        action="store_true",
        help="all that is logged, not warnings alone; with --check every doubt about every part",
    )
    return parser


def _device(text: str) -> str:
    if not re.fullmatch(r"auto|cpu|(cuda:)?\d+", text):
        raise argparse.ArgumentTypeError(f"{text!r} is neither cpu nor the number of a GPU")
    return text


def _as_a_setting(unknown: Sequence[str]) -> str:
    """Arguments that are no options, as overrides of a recipe.

    >>> _as_a_setting(["--captures", "my_captures"]), _as_a_setting(["my_captures"])
    ('try --set captures=my_captures', 'settings of the recipe are given by --set KEY=my_captures')
    """
    first, *rest = unknown
    if not first.startswith("--"):
        return f"settings of the recipe are given by --set {shlex.quote(f'KEY={first}')}"
    key, equals, value = first.removeprefix("--").partition("=")
    value = value if equals else next(iter(rest), "VALUE")
    return f"try --set {shlex.quote(f'{key}={value}')}"


def main(argv: Sequence[str] | None = None) -> int:
    taking = parser()
    if not (sys.argv[1:] if argv is None else argv):
        taking.print_help()
        return DONE
    arguments, unknown = taking.parse_known_args(argv)
    _take_run_folder(arguments)
    if unknown:
        taking.error(f"unrecognized arguments: {shlex.join(unknown)}; {_as_a_setting(unknown)}")
    if arguments.device:
        os.environ[DEVICE_VARIABLE] = arguments.device
    command = shlex.join(["tacos-run", *(sys.argv[1:] if argv is None else argv)])
    return exit_status(lambda: _run(arguments, command))


def _take_run_folder(arguments: argparse.Namespace) -> None:
    """Read `--resume DIR` as the run in that folder, with the recipe that it keeps."""
    folder = Path(arguments.recipe)
    if (arguments.resume or arguments.extend) and arguments.out is None and (folder / RUN_RECIPE).is_file():
        arguments.out, arguments.recipe = folder, str(folder / RUN_RECIPE)


def _run(arguments: argparse.Namespace, command: str) -> int:
    from tacos_framework.plan import Plan
    from tacos_framework.plugins import Plugins
    from tacos_framework.recipe import Recipe

    plugins = Plugins.discover()
    recipe, faults = _read(arguments, plugins)
    longer, extend = _to_go_on_with(arguments, recipe, plugins, faults)
    planned = _plan_study if isinstance(recipe, Recipe) else _plan_procedure
    plan, explanation = planned(longer, plugins, faults)
    if arguments.explain:
        print(explanation())
    if arguments.check:
        from tacos_framework.cli.remarks import remarks

        lines = [*remarks(plan, verbose=arguments.verbose)] if isinstance(plan, Plan) else []
        print("\n".join([f"{arguments.recipe}: no faults.", *lines]))
    if arguments.check or arguments.explain:
        return DONE
    return _run_it(arguments, plan if longer is recipe else recipe, plugins, extend, command)


def _to_go_on_with(
    arguments: argparse.Namespace, recipe: Recipe | ProcedureRecipe, plugins: Plugins, faults: list[Fault]
) -> tuple[Recipe | ProcedureRecipe, dict[str, int]]:
    """The recipe, as long as a run to go on with was extended to already; and by how much to raise that."""
    from tacos_framework.recipe import Recipe

    extend = _extend(arguments, faults)
    if not (arguments.resume or arguments.extend):
        return recipe, extend
    if arguments.out is None:
        option = "--resume" if arguments.resume else "--extend"
        faults.append(Fault(option, "which run is not said", "", "Name its folder with --out."))
    elif arguments.extend and not isinstance(recipe, Recipe):
        faults.append(Fault("--extend", "only studies can be extended", "", "Leave it out."))
    elif isinstance(recipe, Recipe) and not faults:
        from tacos_framework.study.extension import for_resuming

        recipe = for_resuming(recipe, arguments.out, plugins, extend)
        for key, more in extend.items():
            total = recipe.optimizer.settings.get(key)
            print(f"{key}: {more} more" + (f", {total} in all." if total else "."))
    return recipe, extend


def _run_it(
    arguments: argparse.Namespace,
    given: Recipe | ProcedureRecipe | Plan | ProcedurePlan,
    plugins: Plugins,
    extend: Mapping[str, int],
    command: str,
) -> int:
    from tacos_framework.cli.bar import progress_for
    from tacos_framework.runner import run
    from tacos_framework.study import BROKEN_OFF, DEFECT

    out = arguments.out or Path("runs") / f"{Path(arguments.recipe).stem}-{datetime.now():%Y%m%d-%H%M%S}"
    progress_shown = progress_for(quiet=arguments.quiet, verbose=arguments.verbose)
    with progress_shown as progress, ended_by_sigterm():
        result = run(
            given,
            out=out,
            plugins=plugins,
            resume=arguments.resume or bool(arguments.extend),
            extend=extend,
            accept_changes=arguments.accept_changes,
            progress=progress,
            command=command,
        )
    print(summary(result, out))
    stopped = str(result.get("stopped"))
    if stopped.startswith(DEFECT):
        return FAILED
    return INTERRUPTED if stopped == BROKEN_OFF else DONE


def _plan_study(recipe: Any, plugins: Plugins, faults: list[Fault]) -> tuple[Plan, Callable[[], str]]:
    """Check a study's recipe; returns its plan, and what explains it."""
    from tacos_framework.cli.explain import explain
    from tacos_framework.plan import make_plan

    plan = make_plan(recipe, plugins, faults)
    return plan, lambda: explain(plan)


def _plan_procedure(
    recipe: Any, plugins: Plugins, faults: list[Fault]
) -> tuple[ProcedurePlan, Callable[[], str]]:
    """Check a procedure's recipe; returns its plan, and what explains it."""
    from tacos_framework.cli.explain import explain_procedure
    from tacos_framework.plan.procedure import plan_procedure

    plan = plan_procedure(recipe, plugins, faults)
    return plan, lambda: explain_procedure(plan)


def _read(arguments: argparse.Namespace, plugins: Plugins) -> tuple[Recipe | ProcedureRecipe, list[Fault]]:
    from tacos_framework.recipe.loading import read_any_recipe

    faults = [*_device_faults(arguments.device, plugins)]
    sets = _sets(arguments, plugins, faults)
    effects, places = _effects(arguments, faults)
    try:
        recipe, found = read_any_recipe(arguments.recipe, sets, effects, places)
    except UserError as error:
        raise UserError([*faults, *error.faults]) from error
    return recipe, [*faults, *found]


def _device_faults(given: str | None, plugins: Plugins) -> Iterator[Fault]:
    """The fault of the chosen device: a GPU that this machine does not have."""
    device = given or os.environ.get(DEVICE_VARIABLE, "")
    number = device.removeprefix("cuda:")
    if not (number.isascii() and number.isdecimal()) or (gpus := plugins.offers.gpus()) is None:
        return
    if int(number) not in [gpu.number for gpu in gpus]:
        known = ", or ".join(["cpu", *(f"{gpu.number} ({gpu.name})" for gpu in gpus)])
        found = "this machine has no GPU that can be used" if not gpus else f"there is no GPU {number}"
        remedy = "Name one of these, or leave it out: the best there is is then used."
        yield Fault(f"--device {device}" if given else f"{DEVICE_VARIABLE}={device}", found, known, remedy)


def _sets(arguments: argparse.Namespace, plugins: Plugins, faults: list[Fault]) -> dict[str, Any]:
    from tacos_framework.settings.yaml_reader import read_yaml_draft

    sets: dict[str, Any] = {}
    for given in arguments.sets:
        key, equals, value = given.partition("=")
        if not equals or not key:
            faults.append(Fault(f"--set {given}", "there is no '='", "--set key=value"))
            continue
        try:
            document = read_yaml_draft(value, name=f"--set {key}")
        except UserError as error:
            found = error.faults
        else:
            found = document.faults
        faults.extend(replace(fault, where=f"--set {key}") for fault in found)
        if not found:
            sets[key] = document.data
    if arguments.seed is not None:
        sets["seed"] = arguments.seed
    if arguments.executor is not None:
        sets["executor"] = {"use": arguments.executor}
    if arguments.workers is not None:
        executor = arguments.executor or plugins.default("workers", where="--workers")
        sets["executor"] = {"use": executor, "workers": arguments.workers}
    return sets


def _extend(arguments: argparse.Namespace, faults: list[Fault]) -> dict[str, int]:
    extend: dict[str, int] = {}
    for given in arguments.extend:
        key, _, number = given.partition("=")
        if key and number.isdecimal() and int(number) > 0:
            extend[key] = int(number)
        else:
            faults.append(Fault(f"--extend {given}", "it is no KEY=N", "--extend generations=10"))
    return extend


def _effects(
    arguments: argparse.Namespace, faults: list[Fault]
) -> tuple[list[Mapping[str, Any]], dict[tuple[str | int, ...], str]]:
    """The effects of all files, and where each entry of them stands, by index and path."""
    from tacos_framework.settings.yaml_reader import read_yaml_draft

    effects: list[Mapping[str, Any]] = []
    places: dict[tuple[str | int, ...], str] = {}
    for file in arguments.effects:
        try:
            document = read_yaml_draft(Path(file))
        except UserError as error:
            faults += error.faults
            continue
        faults += document.faults
        root = ("effects",) if isinstance(document.data, dict) else ()
        listed = document.data.get("effects") if isinstance(document.data, dict) else document.data
        if not isinstance(listed, list) or not all(isinstance(effect, dict) for effect in listed):
            expected = "a list such as [{use: effect.vignetting, k1: -0.4}]"
            faults.append(Fault(document.where(root), "no list of effects", expected))
            continue
        for path in document.positions:
            if path[: len(root)] == root and len(path) > len(root):
                index, *below = path[len(root) :]
                places[len(effects) + int(index), *below] = document.where(path)
        effects += listed
    return effects, places
