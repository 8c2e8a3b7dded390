"""Things that surfaces belong to, and their classes."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from tacos_framework import Fault, UserError, read_yaml
from tacos_framework.files import CSV_SUFFIXES, read_rows
from tacos_worlds.kit.class_names import CLASS_NAMES
from tacos_worlds.kit.models.model import Surface

BACKGROUND = CLASS_NAMES[0]
EXTRA_KEYS = ("class", "class_name", "category", "semantic", "label")
"""Properties of a node that name its class (in Blender: custom properties, exported with 'Custom
Properties')."""

_WORDS: Mapping[str, tuple[str, ...]] = {
    "sofa": ("sofa", "couch", "armchair", "settee", "loveseat"),
    "bed": ("bed", "bunkbed", "mattress", "crib"),
    "table": ("table", "desk", "nightstand", "workbench", "countertop"),
    "chair": ("chair", "stool", "bench"),
    "bathtub": ("bathtub", "bath", "tub"),
    "basin": ("basin", "sink", "washbasin"),
    "computer_tv": ("tv", "television", "monitor", "screen", "computer", "laptop"),
    "plant": ("plant", "pottedplant", "houseplant", "flower"),
    "lamp": ("lamp", "floorlamp", "tablelamp", "luminaire"),
    "toy": ("toy", "teddy", "doll", "ball"),
    "threshold": ("threshold", "doorsill", "sill", "saddle", "doorstep", "curb", "kerb"),
}
"""Words in the names of nodes that name a class of `scene.indoor`, so that networks trained there know it."""


@dataclass(frozen=True)
class Rule:
    """Surfaces whose name matches a pattern are of a class."""

    pattern: str
    """With ``*`` and ``?``, of a node's name or of its whole path; small and capital letters are alike."""
    class_name: str

    def matches(self, names: Sequence[str]) -> int | None:
        """Number of names from the root to the one that matches; None where none does."""
        pattern = self.pattern.lower()
        for depth, name in enumerate(names, start=1):
            whole = "/".join(names[:depth]).lower()
            if fnmatchcase(name.lower(), pattern) or fnmatchcase(whole, pattern):
                return depth
        return None


def read_table(file: Path) -> tuple[list[Rule], list[Fault]]:
    """Rules of a table: CSV with the columns pattern and class, or YAML with ``pattern: class``."""
    if file.suffix.lower() not in CSV_SUFFIXES:
        return _from_yaml(file)
    try:
        headings, lines = read_rows(file)
    except UserError as error:
        return [], list(error.faults)
    if missing := [name for name in ("pattern", "class") if name not in headings]:
        return [], [Fault(f"{file}:1", f"has no column {', '.join(missing)}", "the columns pattern, class")]
    rules, faults = [], []
    for number, row in lines:
        if row.get("pattern") and row.get("class"):
            rules.append(Rule(row["pattern"], row["class"]))
        else:
            faults.append(Fault(f"{file}:{number}", "lacks a pattern or a class"))
    return rules, faults


def _from_yaml(file: Path) -> tuple[list[Rule], list[Fault]]:
    try:
        table = read_yaml(file).data
    except UserError as error:
        return [], list(error.faults)
    if not isinstance(table, dict) or not all(
        isinstance(key, str) and isinstance(value, str) for key, value in table.items()
    ):
        return [], [Fault(str(file), "is not a mapping of names", "lines of pattern: class")]
    return [Rule(pattern, name) for pattern, name in table.items()], []


@dataclass(frozen=True)
class Label:
    """Thing and class of a surface."""

    thing: str  # names the thing: surfaces of one thing share it. Empty for the background
    class_name: str


def label_of(surface: Surface, rules: Sequence[Rule]) -> Label:
    """By the first rule that matches, else by the node's own properties, else by words in its names."""
    for rule in rules:
        if (depth := rule.matches(surface.path)) is not None:
            return _label(surface, depth, rule.class_name)
    for key in EXTRA_KEYS:
        named = surface.extras.get(key)
        if isinstance(named, str) and named.strip():
            return _label(surface, _owner_depth(surface), named.strip())
    for depth, name in enumerate(surface.path, start=1):
        if (class_name := class_in(name)) is not None:
            return _label(surface, depth, class_name)
    return Label("", BACKGROUND)


def class_in(name: str) -> str | None:
    """The class that a word of a name tells: ``Sofa_02.LOD0`` is a sofa, ``bedroom`` is none.

    >>> class_in("SM_OfficeChair_03"), class_in("bedroom wall"), class_in("door-sill.001")
    ('chair', None, 'threshold')
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    words = [word.lower() for word in re.split(r"[^A-Za-z]+", apart) if word]
    words += ["".join(pair) for pair in itertools.pairwise(words)]
    for class_name, known in _WORDS.items():
        if any(word in known or word.removesuffix("s") in known for word in words):
            return class_name
    return None


def class_names(labels: Sequence[Label]) -> tuple[str, ...]:
    """Those of `scene.indoor` first, in its order, then all others by name."""
    others = sorted({label.class_name for label in labels} - set(CLASS_NAMES))
    return (*CLASS_NAMES, *others)


def unused_rules(surfaces: Sequence[Surface], rules: Sequence[Rule]) -> Iterator[Rule]:
    return (rule for rule in rules if all(rule.matches(surface.path) is None for surface in surfaces))


def _label(surface: Surface, depth: int, class_name: str) -> Label:
    if class_name == BACKGROUND:
        return Label("", BACKGROUND)
    return Label("/".join(surface.path[:depth]), class_name)


def _owner_depth(surface: Surface) -> int:
    """The node of a surface: without the name of its mesh, which several nodes may share."""
    return max(1, len(surface.path) - 1)
