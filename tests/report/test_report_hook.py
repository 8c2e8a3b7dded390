"""Reports come in by a hook: whatever becomes of one, the result stays."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import toy_plugin

from tacos_framework.cli import tacos_main
from tacos_framework.errors import UserError
from tacos_framework.hookspecs import hookimpl
from tacos_framework.plugins import Plugins
from tacos_framework.runner import run
from tests.toy_study import toy_recipe


class BrokenReport:
    """A plugin whose report fails."""

    def __init__(self, error: BaseException) -> None:
        self.error = error

    @hookimpl
    def tacos_report(self, folder: Path) -> Path:
        raise self.error


class OtherReport:
    """A plugin with a report of its own."""

    @hookimpl
    def tacos_report(self, folder: Path) -> Path:
        path = folder / "summary.txt"
        path.write_text("one line\n")
        return path


@pytest.mark.parametrize(
    "error", [KeyError("verdict"), OSError(28, "No space left on device"), SystemExit(3)]
)
def test_a_report_that_fails_costs_no_result(
    error: BaseException, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    plugins = Plugins.discover()
    plugins.register(toy_plugin)
    plugins.register(BrokenReport(error), "broken")
    result = run(toy_recipe(optimizer={"generations": 1}), out=tmp_path / "out", plugins=plugins)
    assert json.loads((tmp_path / "out" / "result.json").read_text())["best"] == result["best"]
    assert (tmp_path / "out" / "report.html").exists(), "another plugin's report is written all the same"
    assert "no report by broken: its tacos_report failed: " in caplog.text


def test_every_plugin_may_report(tmp_path: Path) -> None:
    plugins = Plugins()
    plugins.register(OtherReport(), "other")
    assert plugins.offers.write_reports(tmp_path) == ([tmp_path / "summary.txt"], [])


def test_the_result_of_a_procedure_is_left_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "result.json").write_text('{"procedure": "procedure.diagnose"}')
    (tmp_path / "report.html").write_text("its own")
    assert tacos_main(["report", str(tmp_path)]) == 2
    assert "no plugin reports on it" in capsys.readouterr().err
    assert (tmp_path / "report.html").read_text() == "its own"


def test_a_broken_result_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "result.json").write_text("{")
    assert tacos_main(["report", str(tmp_path)]) == 2
    assert "it is no JSON" in capsys.readouterr().err
    _, (failure,) = Plugins.discover().offers.write_reports(tmp_path)
    assert isinstance(failure.error, UserError)
