"""Contract of procedures: recipes that are no study."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Protocol

from tacos_framework.contracts.executor import Executor
from tacos_framework.settings import Settings


class Procedure(Protocol):
    """A recipe's work that is not a study: a calibration, a validation, a comparison, a diagnosis.

    Its recipe has ``use: procedure.NAME`` at the top, and the settings of its ``Config`` beside it. Of the
    keywords of `run` a procedure asks for those it needs; one that asks for `resume` can go on where a
    broken run stopped.

    ========  =============================================================================================
    out       the results folder, `pathlib.Path`, there and empty (with `resume`: that of the broken run)
    seed      seed of the recipe
    plugins   the installed `Plugins`, to resolve other components
    executor  the recipe's `Executor`, for work that can be shared out
    progress  the `Progress` to tell: ``phase(title, steps)``, then ``step()`` for each
    resume    whether to go on with a broken run
    ========  =============================================================================================

    `ProcedureBase` has an optional member.
    """

    Config: ClassVar[type[Settings]]

    def run(
        self, *, out: Any, seed: int, plugins: Any, executor: Executor, progress: Any, resume: bool
    ) -> Mapping[str, Any]:
        """Do it. Pictures and ``report.html`` go into `out`; what is returned becomes ``result.json``.

        The entry ``summary`` of the result is a text in a few lines, which ``tacos-run`` prints.
        """
        ...


class ProcedureBase:
    """Optional members of a `Procedure`, with their defaults."""

    check: Callable[..., None] | None = None
    """``check(*, seed, plugins)``: raises a `UserError` with whatever its settings lead to that cannot be
    run, such as faults of the recipes they name. It is called as the recipe is checked, with those keywords
    that it asks for."""
