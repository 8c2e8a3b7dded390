"""What all tests share."""

from __future__ import annotations

import os
import signal
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))  # `toy_plugin`, also in spawned workers

import toy_plugin

from tacos_framework.plugins import Plugins

os.environ["TACOS_CACHE"] = "off"  # tests build their worlds; those of the store say where theirs is

# How long a case takes is the machine's affair. `--hypothesis-profile=search` tries new cases at each run;
# the suite itself draws the same ones, so that what passed here passes elsewhere.
settings.register_profile("search", deadline=None)
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")

collect_ignore = ["fuzz/harness.py"]  # run by hand: needs atheris

LONGEST_FIRST = (
    "study/test_resume.py",
    "procedure/test_calibrate_camera.py",
    "docs/test_tutorials.py",
    "testing/test_default_plugins.py",
    "gap/answer/test_diagnosis.py",
    "cli/test_run.py",
    "decision/test_ends_of_studies.py",
    "third_party/test_example_plugin.py",
    "validation/test_studies_table.py",
    "fuzz/test_damaged_texts.py",
    "docs/test_pages.py",
    "worlds/imported/test_imported_scene.py",
)
"""Files of more than 25 s, which run first: a long file that comes last leaves one of two processes idle."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first, all else in the order it has."""
    order = {Path(__file__).parent / name: place for place, name in enumerate(LONGEST_FIRST)}
    items.sort(key=lambda item: order.get(item.path, len(order)))


# Shells start what runs in the background with Ctrl-C ignored, and child processes would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def plugins() -> Plugins:
    """The installed plugins, to be left as they are."""
    return Plugins.discover()


@pytest.fixture(scope="session")
def toys() -> Plugins:
    """The installed plugins and the toys, without analysis and report, which take seconds for each study."""
    return _toys_without("decision", "report")


@pytest.fixture(scope="session")
def reporting_toys() -> Plugins:
    """The installed plugins and the toys, without the analysis of studies."""
    return _toys_without("decision")


def _toys_without(*names: str) -> Plugins:
    plugins = Plugins.discover()
    offers = plugins.offers
    for plugin in [plugin for plugin in offers._plugins if plugin.name in names]:
        offers._plugins.remove(plugin)
        offers._manager.unregister(plugin.hooks)  # or its hooks would answer for each plugin that stays
    plugins.register(toy_plugin)
    return plugins


@pytest.fixture
def distribution(tmp_path, monkeypatch) -> Callable[..., None]:
    """Installs a fake distribution that offers a plugin module of the given source."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def install(name: str, source: str, *, entry_point: str = "", metadata: bool = True) -> None:
        module = name.replace("-", "_")
        (tmp_path / f"{module}.py").write_text(textwrap.dedent(source))
        info = tmp_path / f"{module}-1.0.dist-info"
        info.mkdir()
        if metadata:
            (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        line = entry_point or f"{module} = {module}"
        (info / "entry_points.txt").write_text(f"[tacos]\n{line}\n")
        monkeypatch.delitem(sys.modules, module, raising=False)

    return install
