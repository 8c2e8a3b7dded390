"""Exit statuses, and the one place where a user's mistake becomes one."""

from __future__ import annotations

import re
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import PurePath

from tacos_framework.cli.terminal import printable_output
from tacos_framework.errors import Fault, UserError, printable

DONE = 0
FAILED = 1
WRONG_INPUT = 2
INTERRUPTED = 130
"""128 + SIGINT, as shells expect of a command ended by Ctrl-C."""

_MOST_ALIKE, _FIRST_ALIKE = 8, 3
"""Faults of one kind that are all shown; of more, so many."""


@contextmanager
def ended_by_sigterm() -> Iterator[None]:
    """Take SIGTERM for Ctrl-C meanwhile, as of a scheduler that wants the machine back."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def exit_status(command: Callable[[], int]) -> int:
    """Run a command; print the faults of a `UserError` to stderr instead of a traceback.

    Whatever is printed meanwhile, by commands of plugins too, holds no control characters.
    """
    with printable_output():
        return _status(command)


def _listed(faults: Iterable[Fault]) -> Iterator[str]:
    """Faults as text: of many of one kind the first ones, and of the others where they are."""
    kinds: dict[tuple[str, str, str], list[Fault]] = {}
    for fault in faults:
        what = re.sub(r"\d+", "", fault.what.replace(PurePath(fault.where).name, ""))
        kinds.setdefault((what, fault.expected, fault.remedy), []).append(fault)
    for alike in kinds.values():
        shown = alike if len(alike) <= _MOST_ALIKE else alike[:_FIRST_ALIKE]
        yield from map(str, shown)
        if rest := alike[len(shown) :]:
            yield printable(
                f"{len(rest)} more like it: {', '.join(PurePath(one.where).name for one in rest)}"
            )


def _status(command: Callable[[], int]) -> int:
    try:
        return command()
    except UserError as error:
        count = len(error.faults)
        print(f"{'1 fault' if count == 1 else f'{count} faults'}:\n", file=sys.stderr)
        print("\n\n".join(_listed(error.faults)), file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt as error:
        print(" ".join(("Interrupted", *getattr(error, "__notes__", ()))) + ".", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output went away, e.g. `tacos catalog NAME | head`
        sys.stderr.close()
        return DONE
