"""Conformance suite of procedures."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from tacos_framework.plugins import Plugins
from tacos_framework.study.progress import Silent
from tacos_framework.testing.component import ComponentConformance

SUPPLIED = ("out", "seed", "plugins", "executor", "progress", "resume", "accept_changes")
"""Keywords of a procedure's `run`."""


class InThisProcess:
    """An executor for tests: plain calls."""

    workers = 1

    def map(self, evaluate: Any, jobs: Any) -> Any:
        return map(evaluate, jobs)

    def close(self) -> None:
        """Nothing to let go of."""


@dataclass(frozen=True)
class FinishedRun:
    """Result and files of a run, whatever becomes of its folder."""

    result: Mapping[str, Any]
    files: frozenset[Path]
    """Paths of the files in its folder, below it."""
    beside: frozenset[str]
    """Names in the folder above, its own among them."""


class ProcedureConformance(ComponentConformance):
    """The suite for procedures; give settings under which it takes seconds, and name the files it leaves."""

    kind: ClassVar[str] = "procedure"
    files: ClassVar[tuple[str, ...]] = ()
    plugins: Plugins | None = None
    """The plugins it is run with; those that are installed where None."""
    _finished: ClassVar[FinishedRun | None] = None

    def run(self, out: Path, seed: int = 1) -> Mapping[str, Any]:
        """The procedure's return value, run into an empty folder."""
        out.mkdir()
        procedure = self.make()
        offered: dict[str, Any] = {
            "out": out,
            "seed": seed,
            "plugins": Plugins.discover() if self.plugins is None else self.plugins,
            "executor": InThisProcess(),
            "progress": Silent(),
            "resume": False,
        }
        wanted = inspect.signature(procedure.run).parameters
        result: Mapping[str, Any] = procedure.run(
            **{name: value for name, value in offered.items() if name in wanted}
        )
        return result

    def finished(self, tmp_path: Path) -> FinishedRun:
        """The run that several tests look at, since one may take seconds; the first of them makes it."""
        kept: FinishedRun | None = vars(type(self)).get("_finished")  # not that of a class inherited from
        if kept is None:
            out = tmp_path / "run"
            result = self.run(out)
            files = frozenset(path.relative_to(out) for path in out.rglob("*") if path.is_file())
            kept = FinishedRun(result, files, frozenset(path.name for path in tmp_path.iterdir()))
            type(self)._finished = kept
        return kept

    def comparable(self, result: Mapping[str, Any]) -> Mapping[str, Any]:
        """The part of a result that equal seeds must repeat; override to leave out times."""
        return {name: value for name, value in result.items() if name not in ("summary", "seconds")}

    def test_it_asks_for_keywords_the_framework_supplies(self) -> None:
        for name, parameter in inspect.signature(self.make().run).parameters.items():
            assert parameter.kind is inspect.Parameter.KEYWORD_ONLY, f"{name} is not keyword-only"
            assert name in SUPPLIED, f"nothing supplies {name!r}; known are {', '.join(SUPPLIED)}"

    def test_its_result_is_json_with_a_summary(self, tmp_path: Path) -> None:
        result = self.finished(tmp_path).result
        assert isinstance(result, Mapping)
        json.dumps(dict(result), allow_nan=False)
        assert isinstance(result.get("summary"), str), "the entry 'summary' is a text of a few lines"
        assert result["summary"].strip()

    def test_it_leaves_the_files_it_should(self, tmp_path: Path) -> None:
        left = self.finished(tmp_path).files
        missing = [name for name in self.files if Path(name) not in left]
        assert not missing, f"it left no {', '.join(missing)}"

    def test_it_writes_into_its_folder_alone(self, tmp_path: Path) -> None:
        assert self.finished(tmp_path).beside == {"run"}

    def test_equal_seeds_give_equal_results(self, tmp_path: Path) -> None:
        first, second = (self.comparable(self.run(tmp_path / name)) for name in ("first", "second"))
        assert first == second
