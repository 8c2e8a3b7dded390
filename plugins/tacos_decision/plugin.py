"""The analysis of a finished study; what it needs is imported once there is one."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from functools import partial
from typing import Any

from tacos_framework import Command, hookimpl

log = logging.getLogger(__name__)


@hookimpl
def tacos_commands() -> list[Command]:
    """``tacos predict``."""
    from tacos_decision.predictions.commands import commands

    return commands()


@hookimpl
def tacos_analyse_study(record: Any) -> Mapping[str, Any]:
    """The verdict on the test scenes; all parts ranked, the equals and what matters.

    An analysis that raises costs no verdict.
    """
    from tacos_decision.analysis import analyse
    from tacos_decision.verdict import verdict
    from tacos_framework import in_words, tried

    found, error = tried(partial(analyse, record))
    if error is not None:
        log.warning("no camera is ranked", exc_info=error)
        found = {"ranking_absent": f"No camera can be ranked, as the analysis raised {in_words(error)}."}
    return {**verdict(record), **(found or {}), "reality": _checked_on_reality(record)}


def _checked_on_reality(record: Any) -> str:
    """What predictions of the scores of a study were worth so far, in a sentence."""
    from tacos_decision.predictions.register import misses_in, model_errors, sentence, shipped_register

    kinds = dict.fromkeys(term.score.rpartition(".")[2] for term in record.recipe.fitness)
    return sentence(kinds, model_errors(misses_in([shipped_register()])))
