"""``tacos cache``."""

from __future__ import annotations

import argparse
import re

from tacos_framework import DONE, Command, Fault, UserError

_UNITS = {"": 1, "B": 1, "KB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}


def commands() -> list[Command]:
    """The command; importing this is light."""
    return [Command("cache", "the worlds kept on this machine: show, clear, limit", _arguments, _cache)]


def _arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    actions.add_parser("show", help="where worlds are kept, how many, and what they take")
    actions.add_parser("clear", help="delete them; they are built anew when they are needed")
    limit = actions.add_parser("limit", help="how much they may take; those used longest ago go")
    limit.add_argument("size", metavar="SIZE", help="for example 20GB or 500MB; 0 keeps none")


def _cache(arguments: argparse.Namespace) -> int:
    from tacos_plugins.kept_worlds.store import FOLDER_VARIABLE, store_of_user

    store = store_of_user()
    if store is None:
        print(f"No worlds are kept: {FOLDER_VARIABLE} is off.")
        return DONE
    try:
        if arguments.action == "clear":
            held = store.clear()
            print(f"{held.entries} entries of {_size(held.size_bytes)} deleted.")
        elif arguments.action == "limit":
            store.set_limit(size_bytes(arguments.size))
    except OSError as error:
        raise UserError(
            Fault(str(store.folder), str(error), "a folder that can be written", f"Set {FOLDER_VARIABLE}.")
        ) from error
    now = store.contents()
    print(
        f"{store.folder}: {now.entries} entries, {_size(now.size_bytes)} of {_size(now.limit_bytes)} "
        f"({FOLDER_VARIABLE}=DIR keeps them elsewhere, {FOLDER_VARIABLE}=off nowhere)"
    )
    return DONE


def size_bytes(text: str) -> int:
    """A size in words as bytes.

    Raises `UserError` when it is none.

    >>> size_bytes("20 GB"), size_bytes("1.5gb"), size_bytes("0")
    (20000000000, 1500000000, 0)
    """
    found = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([A-Z]*)", text.strip().upper())
    if found is None or found[2] not in _UNITS:
        raise UserError(
            Fault("tacos cache limit", f"{text!r} is no size", "a number and a unit: 20GB, 500MB")
        )
    return round(float(found[1]) * _UNITS[found[2]])


def _size(size: int) -> str:
    """A size for people to read.

    >>> _size(27_300_000), _size(0)
    ('27.3 MB', '0.0 MB')
    """
    return f"{size / 10**9:.1f} GB" if size >= 10**9 else f"{size / 10**6:.1f} MB"
