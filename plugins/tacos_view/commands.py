"""``tacos view``."""

from __future__ import annotations

import argparse
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tacos_framework import DONE, Command, Fault, UserError

if TYPE_CHECKING:
    from tacos_framework import Plugins

FRAMES = 4


def commands() -> list[Command]:
    return [Command("view", "look at a scene, a camera's frames, an effect, a catalog", _arguments, _view)]


def _arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "what",
        metavar="WHAT",
        nargs="?",
        help="a scene (scene.indoor), a recipe, a study's results folder, or a catalog of parts or cameras",
    )
    parser.add_argument("--effect", metavar="NAME", help="show this effect at rising severities instead")
    parser.add_argument("--camera", metavar="NAME", help="a product of the catalog, or a camera of the run")
    parser.add_argument("--seed", metavar="N", type=int, help="which world, instead of the recipe's seed")
    parser.add_argument("--frames", metavar="N", type=int, default=FRAMES, help=f"how many frames [{FRAMES}]")
    add_sets(parser)
    parser.add_argument("--out", metavar="DIR", type=Path, default=Path("view"), help="the folder [view]")


def add_sets(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="sets",
        action="append",
        default=[],
        help="set a key of the recipe, dotted, or a setting of the scene or effect shown; repeatable",
    )


def read_sets(given: list[str]) -> dict[str, Any]:
    """The values of ``--set``, by key. Raises UserError with every one that cannot be read."""
    from tacos_framework import read_yaml

    sets: dict[str, Any] = {}
    faults: list[Fault] = []
    for each in given:
        key, equals, value = each.partition("=")
        if not (key and equals):
            faults.append(Fault(f"--set {each}", "there is no '='", "--set key=value"))
            continue
        try:
            sets[key] = read_yaml(value, name=f"--set {key}").data
        except UserError as error:
            faults += error.faults
    if faults:
        raise UserError(faults)
    return sets


def _view(arguments: argparse.Namespace) -> int:
    from tacos_framework import Plugins

    if arguments.what is None and arguments.effect is None:
        expected = "a scene, a recipe, a results folder or a catalog, or --effect NAME"
        raise UserError(Fault("tacos view", "there is nothing to look at", expected))
    if arguments.frames < 1:
        raise UserError(Fault("--frames", f"{arguments.frames} frames are none", "1 or more"))
    plugins = Plugins.discover()
    with said_meanwhile(plugins):
        if arguments.effect is not None:
            path = _ladder(arguments, plugins)
        elif kind := _kind_of_catalog(arguments.what):
            path = _catalog(arguments, kind)
        else:
            _look_for(arguments.what, plugins)
            path = _scene(arguments, plugins)
    print(f"Look at {path}")
    return DONE


def said_meanwhile(plugins: Plugins) -> AbstractContextManager[None]:
    """Says on the terminal what components log, such as a world that takes minutes to be lit."""
    from tacos_framework import log_on_terminal

    return log_on_terminal(each.component.target.partition(".")[0] for each in plugins)


def _look_for(what: str, plugins: Plugins) -> None:
    """See that a recipe, a scene or a results folder of this name may be there.

    Raises UserError when there is none, with the name of a recipe, scene or catalog that is nearly the same.
    """
    from tacos_framework import catalog_names, did_you_mean, shipped_recipes

    path = Path(what)
    if what.startswith("scene.") or path.suffix in (".yaml", ".yml") or path.is_file():
        return
    if path.is_dir():
        if not (path / "recipe.yaml").is_file():
            raise UserError(Fault(what, "this folder holds no recipe.yaml", "the results folder of a study"))
        return
    recipes = shipped_recipes()
    if what not in recipes:
        scenes = [each.component.use for each in plugins if each.component.kind == "scene"]
        suggestion = did_you_mean(what, [*recipes, *scenes, *catalog_names(), "cameras"])
        raise UserError(
            Fault(
                what,
                "there is nothing of this name to look at",
                "a scene (scene.indoor), a recipe (headset_quick), a catalog (image_sensors, cameras), or "
                "the results folder of a study",
                suggestion if suggestion.startswith("Did you mean") else "`tacos plugins` lists the scenes.",
            )
        )


def _ladder(arguments: argparse.Namespace, plugins: Plugins) -> Path:
    from tacos_view.effect_ladder import effect_ladder
    from tacos_view.pages import write_ladder
    from tacos_view.setup import set_up

    what = arguments.what or "scene.indoor"
    use = f"effect.{arguments.effect.removeprefix('effect.')}"
    plugins.resolve(
        use, "effect", where=f"--effect {arguments.effect}"
    )  # before anything is rendered in vain
    setup = set_up(what, arguments.camera, sets=LADDER_SETS.get(what), plugins=plugins)
    settings = read_sets(arguments.sets)
    ladder = effect_ladder(setup, arguments.effect, settings, plugins, seed=arguments.seed)
    return write_ladder(arguments.out, ladder, what)


LADDER_SETS: dict[str, dict[str, Any]] = {"scene.indoor": {"nodes.world.size_m": [10, 6], "rig.binning": 2}}
"""A small house and half the pixels are enough to see what an effect does."""


def _kind_of_catalog(what: str) -> Literal["parts", "cameras"] | None:
    """The catalog that a user names, if it is one: by its name, its ending, or the content of the file."""
    from tacos_framework import catalog_names, read_yaml
    from tacos_framework.files import CSV_SUFFIXES

    if what in catalog_names() or what.lower().endswith(CSV_SUFFIXES):
        return "parts"
    path = Path(what)
    if path.suffix.lower() in (".yaml", ".yml") and path.is_file():
        data = read_yaml(path).data
        keys = data.keys() if isinstance(data, dict) and "tacos" not in data else ()
        return "parts" if "parts" in keys else "cameras" if "cameras" in keys else None
    return "cameras" if what == "cameras" and not path.exists() else None


def _catalog(arguments: argparse.Namespace, kind: Literal["parts", "cameras"]) -> Path:
    from tacos_framework import camera_names, find_catalog, load_cameras
    from tacos_view.pages import write_cameras, write_catalog

    if kind == "parts":
        return write_catalog(arguments.out, find_catalog(arguments.what))
    cameras = load_cameras(camera_names(arguments.what), arguments.what)
    return write_cameras(arguments.out, Path(arguments.what).stem, cameras)


def _scene(arguments: argparse.Namespace, plugins: Plugins) -> Path:
    from tacos_view.pages import write_rendering
    from tacos_view.rendering import collected
    from tacos_view.setup import set_up

    sets = read_sets(arguments.sets)
    setup = set_up(arguments.what, arguments.camera, sets=sets, plugins=plugins)
    rendering = collected(setup.along_the_trip(arguments.frames, seed=arguments.seed), setup.camera.title)
    for doubt in rendering.doubts:
        print(f"note: {doubt}")
    return write_rendering(arguments.out, rendering, arguments.what, setup.camera.assumed)
