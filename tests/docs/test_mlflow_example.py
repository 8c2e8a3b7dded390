"""The MLflow tracker of the docs, with a stand-in that records calls, and with MLflow where there is one."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tacos_framework.plugins import Plugins
from tests.docs.pages import ROOT, blocks, write_file
from tests.toy_study import run, toy_recipe

SCRIPT = """
import json, mlflow
from mlflow_tracker import MlflowTracker
from tacos_framework.plugins import Plugins
import toy_plugin
from tests.toy_study import run, toy_recipe
from pathlib import Path

plugins = Plugins.discover()
plugins.register(toy_plugin)
plugins.register(MlflowTracker("cameras"))
run(toy_recipe(), plugins, Path("run"))
client = mlflow.MlflowClient()
(found,) = client.search_runs([client.get_experiment_by_name("cameras").experiment_id])
history = client.get_metric_history(found.info.run_id, "fitness")
assert found.info.status == "FINISHED", found.info.status
assert found.data.params["optimizer"] == "optimizer.genetic"
assert [point.step for point in history] == [0, 1, 2, 3]
written = [json.loads(line) for line in Path("run/generations.jsonl").read_text().splitlines()]
assert [point.value for point in history] == [line["best"]["fitness"] for line in written]
assert "result.json" in [file.path for file in client.list_artifacts(found.info.run_id)]
"""


@pytest.fixture
def tracker_folder(tmp_path: Path) -> Path:
    page = ROOT / "docs" / "how-to" / "embed_the_library.md"
    (block,) = (block for block in blocks(page) if block.title == "mlflow_tracker.py")
    write_file(block, tmp_path)
    return tmp_path


class Recorder(ModuleType):
    """Stands in for mlflow."""

    def __init__(self) -> None:
        super().__init__("mlflow")
        self.calls: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = []

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *args, **keywords: self.calls.append((name, args, keywords))


def test_a_study_becomes_a_run(tracker_folder, toys, monkeypatch):
    recorder = Recorder()
    monkeypatch.setitem(sys.modules, "mlflow", recorder)
    spec = importlib.util.spec_from_file_location("mlflow_tracker", tracker_folder / "mlflow_tracker.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    plugins = Plugins.discover()
    for module_of in toys.modules:
        plugins.register(sys.modules[module_of])
    plugins.register(module.MlflowTracker("cameras"))
    assert plugins.failures == []
    run(toy_recipe(), plugins, tracker_folder / "run")
    written = [
        json.loads(line) for line in (tracker_folder / "run/generations.jsonl").read_text().splitlines()
    ]
    names = [name for name, _, _ in recorder.calls]
    assert names[:4] == ["set_experiment", "end_run", "start_run", "log_params"]
    assert names[-3:] == ["log_metrics", "log_dict", "end_run"]
    generations = [
        (keywords["step"], args[0])
        for name, args, keywords in recorder.calls
        if keywords.get("step") is not None
    ]
    assert [step for step, _ in generations] == [0, 1, 2, 3]
    assert [logged["fitness"] for _, logged in generations] == [line["best"]["fitness"] for line in written]
    assert recorder.calls[-1][1] == ("FINISHED",)


def test_mlflow_holds_the_study(tracker_folder):
    if importlib.util.find_spec("mlflow") is None:
        pytest.skip("MLflow is heavy; it comes with the extra mlflow")
    environment = {
        "PATH": "",
        "PYTHONPATH": f"{tracker_folder}:{ROOT}:{ROOT / 'tests'}",
        "MLFLOW_TRACKING_URI": f"sqlite:///{tracker_folder / 'mlflow.db'}",
        "HOME": str(tracker_folder),
    }
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        cwd=tracker_folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
