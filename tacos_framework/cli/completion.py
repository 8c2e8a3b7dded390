"""``tacos completion SHELL``: static scripts, so that completing starts no Python."""

from __future__ import annotations

import argparse
from collections.abc import Iterable

from tacos_framework.errors import Fault, UserError

SHELLS = ("bash", "zsh", "fish")

_RECIPES = {"bash": "_tacos_recipe_files", "zsh": "_tacos_recipe_files", "fish": "(__tacos_recipes)"}
"""How each shell is asked for recipes; bash takes what this prints for files, as its name says so."""

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

    Parameters
    ----------
    shell
        One of `SHELLS`.
    command
        ``tacos`` or ``tacos-run``; both if None.

    Raises
    ------
    UserError
        When shtab, which writes the scripts, is not installed.
    """
    try:
        import shtab
    except ModuleNotFoundError:
        missing = Fault("tacos completion", "shtab is not installed", "", "pip install shtab")
        raise UserError(missing) from None
    from tacos_framework.shipped import shipped_folder, shipped_names

    recipes = " ".join(shipped_names(shipped_folder("recipes")))
    preamble = _PREAMBLE[shell].format(recipes=recipes)
    parsers = [parser for parser in _parsers() if command in (None, parser.prog)]
    return "\n".join(shtab.complete(parser, shell=shell, preamble=preamble) for parser in parsers)


def _parsers() -> Iterable[argparse.ArgumentParser]:
    """The two command lines, with what their arguments may be."""
    import shtab

    from tacos_framework.catalog import catalog_names
    from tacos_framework.cli import run, tacos
    from tacos_framework.cli.catalogs import CAMERAS
    from tacos_framework.plugins import Plugins

    runs = run.parser()
    components = [registered.component for registered in Plugins.discover()]
    _argument(runs, "recipe").complete = _RECIPES  # type: ignore[attr-defined]
    _argument(runs, "executor").choices = [c.use for c in components if c.kind == "executor"]
    _argument(runs, "effects").complete = shtab.FILE  # type: ignore[attr-defined]
    _argument(runs, "out").complete = shtab.DIRECTORY  # type: ignore[attr-defined]
    around = tacos.parser()
    _argument(_command(around, "catalog"), "name").choices = [CAMERAS, *catalog_names()]
    captures = _command(around, "captures")
    simulate = _command(captures, "simulate", "action")
    _argument(simulate, "recipe").complete = _RECIPES  # type: ignore[attr-defined]
    _argument(simulate, "effects").complete = shtab.FILE  # type: ignore[attr-defined]
    for command, dest in (
        (_command(around, "report"), "folder"),
        (_command(captures, "check", "action"), "folder"),
        (simulate, "out"),
    ):
        _argument(command, dest).complete = shtab.DIRECTORY  # type: ignore[attr-defined]
    return around, runs


def _argument(parser: argparse.ArgumentParser, dest: str) -> argparse.Action:
    return next(action for action in parser._actions if action.dest == dest)


def _command(parser: argparse.ArgumentParser, name: str, dest: str = "command") -> argparse.ArgumentParser:
    commands = _argument(parser, dest).choices
    assert isinstance(commands, dict)
    command: argparse.ArgumentParser = commands[name]
    return command
