"""Observers of a study: they are told, on copies, and one that fails is told no more."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from typing import Any

from tacos_framework.plugins.failures import in_words, tried

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Observer:
    """A plugin that listens to studies."""

    name: str
    """Name of the entry point, module or object."""
    distribution: str | None
    """The distribution it comes from; None where it was registered by hand."""
    hooks: dict[str, Callable[..., Any]]
    """Its hooks by name."""

    def __str__(self) -> str:
        return f"{self.name} of {self.distribution}" if self.distribution else self.name


class Observers:
    """The observers of one study.

    Whatever they do to what they are given, and however they fail, the study is the same.
    """

    def __init__(self, observers: Sequence[Observer] = ()) -> None:
        self._listening = list(observers)

    def tell(self, hook: str, **told: Any) -> None:
        """Tell those that listen to a hook; each has a copy of its own."""
        for observer in list(self._listening):
            listen = observer.hooks.get(hook)
            if listen is None:
                continue
            _, error = tried(partial(listen, **deepcopy(told)), f"{hook} of {observer}")
            if error is not None:
                self._switch_off(observer, hook, error)

    def ask(self, hook: str, **told: Any) -> tuple[dict[str, Any], list[str]]:
        """The keys that those who answer a hook give, and sentences on those whose answer cannot be used.

        What they are told is not copied: it says itself that it must not be changed. Of two that give one
        key the first keeps it.
        """
        answers: dict[str, Any] = {}
        faults = []
        for observer in list(self._listening):
            if (listen := observer.hooks.get(hook)) is None:
                continue
            given, error = tried(partial(_plain_keys, listen, told, answers), f"{hook} of {observer}")
            if error is not None:
                self._switch_off(observer, hook, error)
                faults.append(f"The analysis of {observer} is left out, as it raised {in_words(error)}.")
            else:
                answers.update(given or {})
        return answers, faults

    def _switch_off(self, observer: Observer, hook: str, error: BaseException) -> None:
        self._listening.remove(observer)
        warning = (
            f"the observer {observer} is switched off, as its {hook} raised {in_words(error)}; "
            "the study goes on without it"
        )
        log.warning("%s", warning, exc_info=error)


def _plain_keys(
    listen: Callable[..., Any], told: Mapping[str, Any], known: Mapping[str, Any]
) -> dict[str, Any]:
    """Answers of a hook, as plain data.

    Raises `ValueError` or `TypeError` when it is no mapping, has a key of another, or holds what JSON cannot.
    """
    keys: dict[str, Any] = {}
    for answer in listen(**told):
        if not isinstance(answer, Mapping):
            raise TypeError(f"it answers {type(answer).__name__}, where keys and values are expected")
        if taken := sorted(set(answer) & (set(known) | set(keys))):
            raise ValueError(f"it answers {', '.join(taken)}, which another plugin answers")
        keys.update(json.loads(json.dumps(dict(answer), allow_nan=False)))
    return keys
