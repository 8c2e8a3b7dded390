"""Damage to files, drawn from a seed: what disks, networks and enemies do to them."""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Callable
from copy import deepcopy
from typing import Any

PIECES = (
    b"\0",
    b"\xff" * 4,
    b"\0" * 8,
    b"\x7f\xff\xff\xff",
    b"-1",
    b"nan",
    b"1e999",
    b"../",
    b"{",
    b"[",
    b'"',
    b"\n",
)
VALUES = (
    None,
    True,
    -1,
    0,
    1,
    2**31,
    2**63,
    10**30,
    1e308,
    "",
    "..",
    "../../etc/passwd",
    "\0",
    "\x1b[2J",
    [],
    {},
    [[]],
)


def damaged(content: bytes, draw: random.Random, *, structure: str = "") -> bytes:
    """A file with one to three pieces of damage.

    `structure`: ``json`` or ``glb``, where entries of the tree inside may be damaged too; empty for bytes
    alone.
    """
    if structure and draw.random() < 0.6:
        return _in_tree(content, draw, structure)
    for _ in range(draw.choice((1, 1, 2, 3))):
        content = draw.choice(_OF_BYTES)(content, draw)
    return content


def cut(content: bytes, draw: random.Random) -> bytes:
    """The file up to some place."""
    return content[: draw.randrange(len(content) + 1)]


def _flipped(content: bytes, draw: random.Random) -> bytes:
    return _with_bits(content, draw, len(content))


def _flipped_in_header(content: bytes, draw: random.Random) -> bytes:
    return _with_bits(content, draw, min(len(content), 200))


def _with_bits(content: bytes, draw: random.Random, end: int) -> bytes:
    changed = bytearray(content)
    for _ in range(draw.choice((1, 2, 8)) if end else 0):
        changed[draw.randrange(end)] ^= 1 << draw.randrange(8)
    return bytes(changed)


def _with_number(content: bytes, draw: random.Random) -> bytes:
    """A number of 16 or 32 bits replaced by an extreme one, near the beginning more often than not."""
    end = min(len(content), draw.choice((64, 512, 10**9)))
    if end < 4:
        return content
    at = draw.randrange(end - 3)
    letter = draw.choice(("<H", ">H", "<I", ">I"))
    most = 2 ** (8 * struct.calcsize(letter)) - 1
    number = draw.choice((0, 1, most, most // 2, most // 2 + 1, 20_000, most // 100))
    packed = struct.pack(letter, min(number, most))
    return content[:at] + packed + content[at + len(packed) :]


def _with_piece(content: bytes, draw: random.Random) -> bytes:
    at = draw.randrange(len(content) + 1)
    return content[:at] + draw.choice(PIECES) + content[at:]


def _without_piece(content: bytes, draw: random.Random) -> bytes:
    at = draw.randrange(len(content) + 1)
    return content[:at] + content[at + draw.choice((1, 4, 40, 400)) :]


def _doubled(content: bytes, draw: random.Random) -> bytes:
    at = draw.randrange(len(content) + 1)
    return content[:at] + content[at : at + draw.choice((4, 40, 400))] + content[at:]


_OF_BYTES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    cut,
    _flipped,
    _flipped_in_header,
    _with_number,
    _with_piece,
    _without_piece,
    _doubled,
)


def _in_tree(content: bytes, draw: random.Random, structure: str) -> bytes:
    if structure == "json":
        tree = json.loads(content)
        _damage_tree(tree, draw)
        return json.dumps(tree).encode()
    (length,) = struct.unpack_from("<I", content, 12)
    tree, rest = json.loads(content[20 : 20 + length]), content[20 + length :]
    _damage_tree(tree, draw)
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    whole = 20 + len(text) + len(rest)
    return struct.pack("<4sIII4s", b"glTF", 2, whole, len(text), b"JSON") + text + rest


def _damage_tree(tree: Any, draw: random.Random) -> None:
    for _ in range(draw.choice((1, 1, 2))):
        places = _containers(tree)
        if not places:
            return
        place = draw.choice(places)
        key = draw.choice(list(place) if isinstance(place, dict) else range(len(place)))
        how = draw.randrange(4)
        if how == 0:
            del place[key]
        elif how == 1 and isinstance(place[key], int) and not isinstance(place[key], bool):
            place[key] = draw.choice((place[key] * 10**6, place[key] + 1, -place[key], 3 * 10**8))
        elif how == 2:
            other = draw.choice(places)
            place[key] = json.loads(json.dumps(other))
        else:
            place[key] = deepcopy(draw.choice(VALUES))


def _containers(value: Any) -> list[Any]:
    inner = list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []
    found = [value] if inner else []
    return found + [container for item in inner for container in _containers(item)]
