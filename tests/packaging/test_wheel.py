"""What a user gets from `pip install tacos-framework`: the wheel, built and looked into."""

from __future__ import annotations

import configparser
import os
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from email.parser import Parser
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PLUGINS = (
    "tacos_plugins",
    "tacos_worlds",
    "tacos_gap",
    "tacos_report",
    "tacos_validation",
    "tacos_decision",
    "tacos_view",
    "tacos_export",
    "tacos_files",
    "tacos",
)
PACKAGES = ("tacos_framework", *(f"plugins/{name}" for name in PLUGINS))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[zipfile.ZipFile]:
    """The wheel of this repository, built by its own backend without network."""
    out = tmp_path_factory.mktemp("dist")
    build = "import sys, hatchling.build; print(hatchling.build.build_wheel(sys.argv[1]))"
    done = subprocess.run(
        [sys.executable, "-c", build, str(out)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    (path,) = out.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        yield archive


def metadata(wheel: zipfile.ZipFile, name: str) -> str:
    """A file of the wheel's .dist-info folder."""
    (path,) = (entry for entry in wheel.namelist() if entry.endswith(f".dist-info/{name}"))
    return wheel.read(path).decode()


def files_in(*folders: str) -> set[str]:
    """The files of some folders of the repository, but for what Python leaves behind."""
    files = (path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file())
    return {str(path.relative_to(ROOT)) for path in files if "__pycache__" not in path.parts}


def test_every_file_of_the_packages_is_there(wheel: zipfile.ZipFile) -> None:
    expected = {path.removeprefix("plugins/") for path in files_in(*PACKAGES)}
    assert expected <= set(wheel.namelist())


def test_every_folder_of_modules_is_a_package() -> None:
    """Without ``__init__.py`` a folder is imported all the same, but the layer checks do not see it."""
    folders = {(ROOT / path).parent for path in files_in(*PACKAGES) if path.endswith(".py")}
    assert [str(folder) for folder in folders if not (folder / "__init__.py").is_file()] == []


def test_recipes_and_catalogs_lie_inside_the_framework(wheel: zipfile.ZipFile) -> None:
    expected = {f"tacos_framework/{path}" for path in files_in("recipes", "catalogs")}
    assert "tacos_framework/recipes/headset_quick.yaml" in expected
    assert expected <= set(wheel.namelist())


def test_shaders_and_type_markers_are_there(wheel: zipfile.ZipFile) -> None:
    names = wheel.namelist()
    assert any(name.startswith("tacos_plugins/") and name.endswith(".glsl") for name in names)
    assert {f"{package}/py.typed" for package in ("tacos_framework", *PLUGINS)} <= set(names)


def test_nothing_else_is_installed(wheel: zipfile.ZipFile) -> None:
    folders = {name.partition("/")[0].rpartition(".")[2] for name in wheel.namelist()}
    assert folders == {"tacos_framework", *PLUGINS, "dist-info"}


def test_entry_points(wheel: zipfile.ZipFile) -> None:
    points = configparser.ConfigParser()
    points.read_string(metadata(wheel, "entry_points.txt"))
    assert dict(points["tacos"]) == {
        "defaults": "tacos_plugins.plugin",
        "worlds": "tacos_worlds.plugin",
        "gap": "tacos_gap.plugin",
        "report": "tacos_report.plugin",
        "validation": "tacos_validation.plugin",
        "decision": "tacos_decision.plugin",
        "view": "tacos_view.plugin",
        "export": "tacos_export.plugin",
    }
    assert dict(points["tacos_loops"]) == {"spline": "tacos_plugins.compiled.spline:evaluate"}
    assert dict(points["console_scripts"]) == {
        "tacos-run": "tacos_framework.cli:run_main",
        "tacos": "tacos_framework.cli:tacos_main",
    }


def test_shipped_recipes_run_by_name_from_an_installed_wheel(wheel: zipfile.ZipFile, tmp_path: Path) -> None:
    site, elsewhere = tmp_path / "site", tmp_path / "elsewhere"
    wheel.extractall(site)
    elsewhere.mkdir()
    code = (
        "import sys, tacos_framework, tacos_framework.cli as cli;"
        "assert tacos_framework.__file__.startswith(sys.argv.pop(1));"
        "sys.exit(cli.run_main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(site), "headset_quick", "--check"],
        cwd=elsewhere,
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_licence(wheel: zipfile.ZipFile) -> None:
    fields = Parser().parsestr(metadata(wheel, "METADATA"))
    assert fields["License-Expression"] == "Apache-2.0"
    assert "Apache License" in metadata(wheel, "licenses/LICENSE")
