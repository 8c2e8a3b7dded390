"""``tacos catalog``, ``recipes``, ``settings``, ``schema``, ``completion`` and ``new-plugin``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tacos_framework import DONE, KINDS, Command

SHELLS = ("bash", "zsh", "fish")


def commands() -> list[Command]:
    """The commands; importing this is light."""
    return [
        Command("catalog", "catalogs of parts and cameras", _catalog_arguments, _catalog),
        Command("recipes", "the recipes that ship, and where they lie", _no_arguments, _recipes),
        Command("settings", "what a component takes and gives, by its name", _settings_arguments, _settings),
        Command("schema", "print the JSON Schema of recipes, for editors", _no_arguments, _schema),
        Command(
            "completion",
            "print a script that completes commands in a shell",
            _completion_arguments,
            _completion,
        ),
        Command(
            "new-plugin", "write a plugin project that passes its tests", _new_plugin_arguments, _new_plugin
        ),
    ]


def _catalog_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", help="a catalog to show; all of them are listed without")
    parser.add_argument(
        "part", nargs="?", help="a part of it, of which all is shown: values, sources, doubts"
    )


def _catalog(arguments: argparse.Namespace) -> int:
    from tacos_plugins.authoring.catalogs import list_catalogs, show_catalog, show_part

    if arguments.part:
        print(show_part(arguments.name, arguments.part))
    else:
        print(show_catalog(arguments.name) if arguments.name else list_catalogs())
    return DONE


def _no_arguments(parser: argparse.ArgumentParser) -> None:
    """There are none."""


def _recipes(arguments: argparse.Namespace) -> int:
    from tacos_plugins.authoring.recipes import list_recipes

    print(list_recipes())
    return DONE


def _settings_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("use", metavar="NAME", help="rig.monocular, task.fiducials, ... or: recipe")


def _settings(arguments: argparse.Namespace) -> int:
    from shutil import get_terminal_size

    from tacos_plugins.authoring.reference.in_terminal import settings_text

    print(settings_text(arguments.use, width=min(get_terminal_size().columns, 110)))
    return DONE


def _schema(arguments: argparse.Namespace) -> int:
    import json

    from tacos_framework import Plugins
    from tacos_plugins.authoring.reference.recipe_schema import recipe_schema

    plugins = Plugins.discover()
    described = recipe_schema(plugins)
    print(json.dumps(described.schema, indent=1, ensure_ascii=False))
    for failure in plugins.failures:
        print(f"left out: plugin {failure.plugin}: {failure.reason}", file=sys.stderr)
    for use, reason in described.undescribed.items():
        print(f"without its settings: {use}: {reason}", file=sys.stderr)
    return DONE


def _completion_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS, help="the shell")
    parser.add_argument("of", nargs="?", choices=("tacos", "tacos-run"), help="one command alone [both]")


def _completion(arguments: argparse.Namespace) -> int:
    from tacos_plugins.authoring.completion import completion_script

    print(completion_script(arguments.shell, arguments.of))
    return DONE


def _new_plugin_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="name of the project, tacos-SOMETHING by habit")
    parser.add_argument(
        "--kind",
        dest="kinds",
        nargs="+",
        choices=KINDS,
        default=["task"],
        metavar="KIND",
        help=f"kinds of component it offers [task]: {', '.join(KINDS)}",
    )
    parser.add_argument("--in", dest="folder", type=Path, default=Path(), help="where to put it [here]")


def _new_plugin(arguments: argparse.Namespace) -> int:
    from tacos_plugins.authoring.scaffold import new_plugin

    for path in new_plugin(arguments.name, arguments.kinds, folder=arguments.folder):
        print(path)
    project = arguments.folder / arguments.name
    print(f"\nInstall and test it:\n  pip install --editable '{project}[test]'\n  pytest {project}")
    return DONE
