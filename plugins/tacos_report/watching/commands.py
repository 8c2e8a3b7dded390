"""The command ``tacos watch``."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from tacos_framework import DONE, Command, Fault, UserError


def commands() -> list[Command]:
    return [Command("watch", "show a study while it runs", _arguments, _watch)]


def _arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="RUN", type=Path, help="results folder of a study")
    parser.add_argument("--every", metavar="S", type=float, default=2.0, help="seconds between looks (2)")
    parser.add_argument("--once", action="store_true", help="look once")
    parser.add_argument("--page", action="store_true", help="also write RUN/watch.html, which reloads itself")


def _watch(arguments: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.live import Live

    from tacos_report.watching.page import write_watch_page
    from tacos_report.watching.running_study import read_running
    from tacos_report.watching.terminal import screen

    if arguments.every <= 0:
        raise UserError(Fault("--every", f"{arguments.every:g} s is no time", "seconds above 0"))
    console = Console()
    page = arguments.folder / "watch.html"
    study = read_running(arguments.folder)
    if arguments.page:
        console.print(str(page), highlight=False, markup=False)
    with Live(screen(study, time.time()), console=console, auto_refresh=False) as live:
        while True:
            now_s = time.time()
            live.update(screen(study, now_s), refresh=True)
            if arguments.page:
                write_watch_page(page, study, now_s=now_s, every_s=arguments.every)
            if arguments.once or study.stopped is not None:
                break
            time.sleep(arguments.every)
            study = read_running(arguments.folder)
    if study.report is not None:
        console.print(str(study.report), highlight=False, markup=False)
    return DONE
