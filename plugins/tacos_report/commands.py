"""``tacos report`` and ``tacos verify``."""

from __future__ import annotations

import argparse
from pathlib import Path

from tacos_framework import DONE, FAILED, Command, Fault, UserError


def commands() -> list[Command]:
    return [
        Command("report", "write the report of a study anew", _arguments, _report),
        Command("verify", "verify the checksums of a run", _arguments, _verify),
    ]


def _arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", type=Path, help="results folder of a run")


def _report(arguments: argparse.Namespace) -> int:
    from tacos_framework import Plugins
    from tacos_framework.store import read_result

    folder = arguments.folder
    read_result(folder)
    written, failures = Plugins.discover().offers.write_reports(folder)
    for path in written:
        print(path)
    for failure in failures:
        assert failure.error is not None
        raise failure.error
    if not written:
        remedy = "A procedure writes its report as it runs; `tacos plugins` lists what is broken."
        raise UserError(Fault(str(folder), "no plugin reports on it", "results of a study", remedy))
    return DONE


def _verify(arguments: argparse.Namespace) -> int:
    from tacos_report.verifying import verify

    checks = verify(arguments.folder)
    for check in checks:
        said = check.damage or check.note
        print(f"{'ok ' if check.damage is None else 'BAD'} {check.name}{f': {said}' if said else ''}")
        if check.damage is not None:
            print(f"    {check.meaning}")
    return DONE if all(check.damage is None for check in checks) else FAILED
