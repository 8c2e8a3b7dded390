"""``tacos captures``: what to photograph, photographs made into a folder, a folder simulated or checked."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from tacos_framework import DONE, Fault, UserError

if TYPE_CHECKING:
    from tacos_gap.captures import CaptureFolder, RealCapture
    from tacos_gap.hypotheses.candidates import Candidates


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    guide = actions.add_parser("guide", help="say what to photograph, in order")
    guide.add_argument("effect", metavar="EFFECT", nargs="?", help="captures for one effect, e.g. vignetting")
    guide.add_argument(
        "--for",
        metavar="FILE",
        dest="diagnosis",
        type=Path,
        help="captures that would settle the open questions of a diagnosis.json",
    )
    _add_import(actions)
    simulate = actions.add_parser("simulate", help="make a folder of captures from our simulator")
    simulate.add_argument(
        "recipe", metavar="RECIPE", help="path of a bench recipe, or name of a shipped one: bench"
    )
    simulate.add_argument("--out", metavar="DIR", type=Path, required=True, help="the folder, new or empty")
    simulate.add_argument(
        "--with",
        metavar="FILE",
        dest="effects",
        action="append",
        default=[],
        help="effects of the real camera, listed in a YAML file; repeatable",
    )
    simulate.add_argument(
        "--set",
        metavar="KEY=VALUE",
        dest="sets",
        action="append",
        default=[],
        help="set a key of the recipe, dotted; repeatable",
    )
    simulate.add_argument("--seed", metavar="N", type=int, help="seed, instead of the recipe's")
    simulate.add_argument("--resume", action="store_true", help="go on with the captures begun in --out")
    simulate.add_argument(
        "--accept-changes",
        action="store_true",
        help="do so although code, versions or files have changed since",
    )
    simulate.add_argument("--quiet", action="store_true", help="no progress bar")
    view = actions.add_parser("view", help="write a page that shows what each picture is taken for")
    view.add_argument("folder", metavar="DIR", type=Path, help="folder with captures.yaml")
    view.add_argument(
        "--out", metavar="FILE", type=Path, help="the page; contact_sheet.html in the folder by default"
    )
    check = actions.add_parser(
        "check", help="check a folder: contents, faults, and effects that it cannot show"
    )
    check.add_argument("folder", metavar="DIR", type=Path, help="folder with captures.yaml")


def _add_import(actions: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    photographs = actions.add_parser("import", help="sort photographs into a folder of captures")
    photographs.add_argument(
        "photos", metavar="PHOTOS", type=Path, nargs="+", help="pictures, or folders of them"
    )
    photographs.add_argument(
        "--out", metavar="DIR", type=Path, required=True, help="the folder, new or empty"
    )
    for name, kind, unit, what in (
        ("--pixel-um", float, "UM", "pitch of the pixels"),
        ("--focal-length-mm", float, "MM", "focal length"),
        ("--black-level-dn", float, "DN", "pedestal in the files"),
        ("--bit-depth", int, "BITS", "bits of a sample"),
        ("--square-mm", float, "MM", "side of the chessboard's squares"),
    ):
        photographs.add_argument(name, metavar=unit, type=kind, help=f"{what}, if the files do not say it")
    photographs.add_argument(
        "--cfa", choices=("RGGB", "BGGR", "GRBG", "GBRG"), help="colour filters of a mosaic in grey files"
    )
    photographs.add_argument(
        "--board", metavar="COLUMNSxROWS", help="inner corners of the chessboard, e.g. 9x6"
    )
    photographs.add_argument(
        "--ask", action="store_true", help="ask about each guess, where there is a terminal to answer in"
    )


def captures(arguments: argparse.Namespace) -> int:
    actions = {"guide": _guide, "import": _import, "simulate": _simulate, "view": _view, "check": _check}
    return actions[arguments.action](arguments)


def _guide(arguments: argparse.Namespace) -> int:
    from tacos_gap.photographs import guide

    if arguments.effect is None and arguments.diagnosis is None:
        print("\n".join(guide.whole_round()))
        return DONE
    from tacos_framework import Plugins
    from tacos_gap.hypotheses.candidates import candidates

    effects = candidates(Plugins.discover()).effects
    if arguments.effect is not None:
        print("\n".join(guide.for_effect(arguments.effect, effects)))
    if arguments.diagnosis is not None:
        print("\n".join(guide.for_diagnosis(arguments.diagnosis, effects)))
    return DONE


def _import(arguments: argparse.Namespace) -> int:
    from functools import partial

    from tacos_gap.photographs.given import Given, asked, corners_of
    from tacos_gap.photographs.importing import import_photographs
    from tacos_gap.photographs.summary import summary

    given = Given(
        pixel_um=arguments.pixel_um,
        focal_length_mm=arguments.focal_length_mm,
        black_level_dn=arguments.black_level_dn,
        bit_depth=arguments.bit_depth,
        cfa=arguments.cfa,
        inner_corners=arguments.board and corners_of(arguments.board),
        square_mm=arguments.square_mm,
    )
    answered = partial(asked, ask=input, tell=print) if arguments.ask and sys.stdin.isatty() else None
    if arguments.ask and answered is None:
        print("--ask: standard input is no terminal, so nothing is asked and the guesses stand.\n")
    imported = import_photographs(arguments.photos, arguments.out, given, answered=answered)
    print("\n".join(summary(imported)))
    return DONE


def _simulate(arguments: argparse.Namespace) -> int:
    from tacos_framework import ProcedureRecipe, read_any_recipe
    from tacos_framework.cli import run_main
    from tacos_gap.simulation.bench.rendering import not_of_a_bench

    recipe, _ = read_any_recipe(arguments.recipe)
    if not isinstance(recipe, ProcedureRecipe) or "captures" not in recipe.settings:
        raise UserError(not_of_a_bench(arguments.recipe))
    options = [f"--out={arguments.out}", *(f"--with={file}" for file in arguments.effects)]
    options += [f"--set={given}" for given in arguments.sets]
    for flag in ("resume", "accept_changes", "quiet"):
        options += [f"--{flag.replace('_', '-')}"] if getattr(arguments, flag) else []
    options += [] if arguments.seed is None else [f"--seed={arguments.seed}"]
    return run_main([arguments.recipe, *options])


def _view(arguments: argparse.Namespace) -> int:
    from tacos_gap.report.contact_sheet import contact_sheet
    from tacos_report.page import write_page

    folder = arguments.folder if arguments.folder.is_dir() else arguments.folder.parent
    out = arguments.out or folder / "contact_sheet.html"
    page = contact_sheet(arguments.folder)
    try:
        write_page(out, page)
    except OSError as error:
        expected = "a file in a folder that may be written in"
        raise UserError(
            Fault(str(out), f"cannot be written: {error.strerror or error}", expected, "Name another --out.")
        ) from error
    print(f"{out}: {page.title}")
    return DONE


def _check(arguments: argparse.Namespace) -> int:
    from tacos_framework import Plugins
    from tacos_gap.captures import read_captures
    from tacos_gap.hypotheses.candidates import candidates
    from tacos_gap.simulation.bench import recipe_renderer

    plugins = Plugins.discover()
    folder = read_captures(arguments.folder, recipe_renderer(plugins))
    print("\n".join(described(folder, candidates(plugins))))
    return DONE


def described(folder: CaptureFolder, considered: Candidates) -> Iterator[str]:
    from tacos_gap.captures.coverage import untold
    from tacos_gap.report.words import captures_in_words, gathered

    first = folder.captures[0]
    geometry, context = first.geometry, first.context
    kind = context.cfa or {1: "mono", 3: "RGB"}[first.real_dn.shape[-1]]
    yield (
        f"{folder.path}: {captures_in_words(len(folder.captures))} by a sensor of "
        f"{geometry.full_width_px} x {geometry.full_height_px}, {kind}, "
        f"{context.black_level_dn:g} to {context.white_level_dn:g} DN"
    )
    yield ""
    times = any(capture.taken_s is not None for capture in folder.captures)
    rows = [("id", "kind", "frames", "ms", "dB", "mean DN", "expected"), *map(_row, folder.captures)]
    if times:
        taken = ("-" if c.taken_s is None else f"{c.taken_s:g}" for c in folder.captures)
        rows = [(*row, cell) for row, cell in zip(rows, ("taken s", *taken), strict=True)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        left = [cell.ljust(width) for cell, width in zip(row[:2], widths, strict=False)]
        right = [cell.rjust(width) for cell, width in zip(row[2:], widths[2:], strict=True)]
        yield "  ".join([*left, *right])
    if folder.limitations or considered.limitations:
        yield from ("", "Limitations")
        yield from (f"  {text}" for text in gathered(folder.limitations))
        yield from (f"  {text}" for text in considered.limitations)
    if lacking := untold(folder.captures, considered.effects):
        yield from ("", "Effects that these captures cannot show, and captures that would")
        yield from (f"  {', '.join(effects)}: {remedy}" for remedy, effects in lacking.items())


def _row(capture: RealCapture) -> tuple[str, ...]:
    expected = "-" if capture.expected_dn is None else f"{capture.expected_dn.mean():.1f}"
    return (
        capture.id,
        capture.kind,
        str(capture.frames),
        f"{capture.context.exposure_s * 1e3:g}" if capture.exposure_stated else "?",
        f"{capture.context.gain_db:g}",
        f"{capture.real_dn.mean():.1f}",
        expected,
    )
