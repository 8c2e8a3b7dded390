"""``tacos``: what is installed, what is wrong, what there is to choose from."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from tacos_framework import __version__
from tacos_framework.cli.exits import DONE, exit_status
from tacos_framework.errors import Fault, UserError, did_you_mean

if TYPE_CHECKING:
    from tacos_framework.environment import EnvironmentFinding
    from tacos_framework.plugins import Plugins


def parser(plugins: Plugins) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tacos", description="Look around tacos-framework.", epilog="Recipes are run by tacos-run."
    )
    parser.add_argument("--version", action="version", version=f"tacos-framework {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    listed = commands.add_parser("plugins", help="components that are installed, and plugins that are broken")
    listed.add_argument(
        "--members", action="store_true", help="load them, and list members that no contract has"
    )
    commands.add_parser("doctor", help="check this machine: OpenGL, cores, torch, plugins")
    for command in plugins.offers.commands(taken=tuple(commands.choices)):
        try:
            command.add_arguments(argparse.ArgumentParser())  # in vain, as a parser once added stays
            command.add_arguments(commands.add_parser(command.name, help=command.help))
        except (Exception, SystemExit) as error:  # noqa: BLE001 - kept and shown by `tacos plugins`
            plugins.offers.reject(command, error)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    return exit_status(lambda: _main(argv))


def _main(argv: Sequence[str] | None) -> int:
    from tacos_framework.plugins import Plugins

    plugins = Plugins.discover()
    given = sys.argv[1:] if argv is None else argv
    taking = parser(plugins)
    names = ["plugins", "doctor", *(command.name for command in plugins.offers.commands())]
    if given and not given[0].startswith("-") and given[0] not in names:
        raise UserError(_no_command(given, names))
    arguments = taking.parse_args(given)
    if arguments.command is None:
        taking.print_help()
        return DONE
    own: dict[str, Callable[[argparse.Namespace], int]] = {
        "plugins": lambda arguments: _plugins(plugins, members=arguments.members),
        "doctor": lambda arguments: _doctor(plugins),
    }
    commands = {command.name: command.run for command in plugins.offers.commands()} | own
    return commands[arguments.command](arguments)


def _no_command(given: Sequence[str], names: Sequence[str]) -> Fault:
    """The fault of a word that is no command: a misspelt one, or what tacos-run takes."""
    from tacos_framework.packaged_resources import shipped_recipes

    recipe = given[0] in shipped_recipes() or given[0].endswith((".yaml", ".yml"))
    if recipe or given[0] == "run":
        rest = given if recipe else given[1:] or ["RECIPE"]
        remedy = f"Recipes are run by another command. Try: {shlex.join(['tacos-run', *rest])}"
    else:
        remedy = did_you_mean(given[0], names)
    return Fault(f"tacos {given[0]}", "there is no such command", remedy=remedy)


def _plugins(plugins: Plugins, *, members: bool) -> int:
    for registered in plugins:
        component = registered.component
        missing = component.missing_packages()
        note = f" (needs: pip install {' '.join(missing)})" if missing else ""
        print(
            f"{component.use:<30} {component.summary}{note}  [{registered.distribution or registered.plugin}]"
        )
    if members:
        _unread_members(plugins)
    for failure in plugins.failures:
        print(f"broken: plugin {failure.plugin}: {failure.reason}. {failure.remedy}", file=sys.stderr)
    return DONE


def _unread_members(plugins: Plugins) -> None:
    """List what the framework never reads of a component: helpers of its author, or names meant otherwise."""
    from tacos_framework.plugins.contract_check import unread_members

    print("\nPublic members that no contract has (helpers, or misspelt names):")
    for registered in plugins:
        try:
            cls = plugins.resolve(registered.component.use)
        except UserError:  # `tacos doctor` says what is wrong with it
            continue
        if names := unread_members(registered.component, cls):
            print(f"{registered.component.use:<30} {', '.join(names)}")


def _doctor(plugins: Plugins) -> int:
    sound = True
    for finding in _findings(plugins):
        sound = sound and finding.ok
        print(f"{'ok  ' if finding.ok else 'BAD '} {finding.name}: {finding.value}", flush=True)
        if finding.remedy and not finding.ok:
            print(f"     to do: {finding.remedy}", flush=True)
    return DONE if sound else 1


def _findings(plugins: Plugins) -> Iterator[EnvironmentFinding]:
    """Findings about this machine, the quick ones first."""
    import platform

    from tacos_framework.environment import EnvironmentFinding, usable_cores

    yield EnvironmentFinding("tacos-framework", __version__)
    yield EnvironmentFinding("Python", platform.python_version())
    yield EnvironmentFinding("cores", str(usable_cores()))
    yield from plugins.offers.findings()
    components = len(list(plugins))
    print(f"     importing {components} components, one after the other", file=sys.stderr)
    broken = [*plugins.failures, *plugins.unusable()]
    for failure in broken:
        yield EnvironmentFinding(f"plugin {failure.plugin}", failure.reason, ok=False, remedy=failure.remedy)
    if not broken:
        yield EnvironmentFinding("plugins", f"{components} components, none of them broken")
