"""``tacos completion SHELL``: static scripts, so that completing starts no Python."""

from __future__ import annotations

import argparse
from collections.abc import Iterable

from tacos_framework import Fault, UserError

_RECIPES = {"bash": "_tacos_recipe_files", "zsh": "_tacos_recipe_files", "fish": "(__tacos_recipes)"}
"""Commands by which each shell asks for recipes; bash takes what this prints for files, as its name says so.
"""

_PREAMBLE = {
    "bash": """\
_tacos_recipe_files() {{
  compgen -W "{recipes}" -- "$1"
  compgen -f -X '!*.@(yaml|yml)' -- "$1"
  compgen -d -- "$1"
}}
shopt -s extglob
""",
    "zsh": """\
_tacos_recipe_files() {{
  _alternative 'recipes:shipped recipe:({recipes})' 'files:recipe:_files -g "*.(yaml|yml)"'
}}
""",
    "fish": """\
function __tacos_recipes
  printf '%s\\n' {recipes}
  __fish_complete_suffix .yaml
end
""",
}


def completion_script(shell: str, command: str | None = None) -> str:
    """The script that completes the commands in a shell.

    `shell`: one of `SHELLS`. `command`: ``tacos`` or ``tacos-run``; both if None.

    Raises `UserError` when shtab, which writes the scripts, is not installed.
    """
    try:
        import shtab
    except ModuleNotFoundError:
        missing = Fault("tacos completion", "shtab is not installed", "", "pip install shtab")
        raise UserError(missing) from None
    from tacos_framework import shipped_recipes

    recipes = " ".join(shipped_recipes())
    preamble = _PREAMBLE[shell].format(recipes=recipes)
    parsers = [parser for parser in _parsers() if command in (None, parser.prog)]
    return "\n".join(shtab.complete(parser, shell=shell, preamble=preamble) for parser in parsers)


def _parsers() -> Iterable[argparse.ArgumentParser]:
    """The two command lines, with what their arguments may be."""
    from tacos_framework import Plugins, catalog_names
    from tacos_framework.cli import run_parser, tacos_parser
    from tacos_plugins.authoring.catalogs import CAMERAS

    plugins = Plugins.discover()
    runs, around = run_parser(), tacos_parser(plugins)
    components = [registered.component for registered in plugins]
    _argument(runs, "executor").choices = [c.use for c in components if c.kind == "executor"]
    catalog = _argument(around, "command").choices["catalog"]  # type: ignore[index]
    _argument(catalog, "name").choices = [CAMERAS, *catalog_names()]
    _complete_by_metavar(around)
    _complete_by_metavar(runs)
    return around, runs


def _complete_by_metavar(parser: argparse.ArgumentParser) -> None:
    """Complete what is called RECIPE, FILE or DIR as such, whichever plugin's command asks for it."""
    import shtab

    completed = {"RECIPE": _RECIPES, "FILE": shtab.FILE, "DIR": shtab.DIRECTORY}
    for action in parser._actions:
        if action.metavar in completed:
            action.complete = completed[str(action.metavar)]  # type: ignore[attr-defined]
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                _complete_by_metavar(below)


def _argument(parser: argparse.ArgumentParser, dest: str) -> argparse.Action:
    return next(action for action in parser._actions if action.dest == dest)
