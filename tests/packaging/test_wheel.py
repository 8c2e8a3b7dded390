"""What a user gets from `pip install tacos-framework`: the wheel, built and looked into."""

from __future__ import annotations

import configparser
import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from email.parser import Parser
from pathlib import Path

import pytest

from tacos_validation.plugin import tacos_components

ROOT = Path(__file__).parents[2]
PLUGINS = (
    "tacos_plugins",
    "tacos_worlds",
    "tacos_gap",
    "tacos_report",
    "tacos_decision",
    "tacos_view",
    "tacos_export",
    "tacos_files",
    "tacos",
)
PACKAGES = ("tacos_framework", *(f"plugins/{name}" for name in PLUGINS))


VALIDATION = ROOT / "plugins/tacos_validation"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[zipfile.ZipFile]:
    yield from built(ROOT, tmp_path_factory.mktemp("dist"))


@pytest.fixture(scope="module")
def validation_wheel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[zipfile.ZipFile]:
    """The wheel of tacos-validation."""
    yield from built(VALIDATION, tmp_path_factory.mktemp("dist"))


def built(root: Path, out: Path) -> Iterator[zipfile.ZipFile]:
    """A wheel, built by its own backend without network."""
    build = "import sys, hatchling.build; print(hatchling.build.build_wheel(sys.argv[1]))"
    done = subprocess.run(
        [sys.executable, "-c", build, str(out)], cwd=root, capture_output=True, text=True, check=False
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


def test_validation_is_a_wheel_of_its_own_with_its_recipes(validation_wheel: zipfile.ZipFile) -> None:
    names = {name for name in validation_wheel.namelist() if ".dist-info/" not in name}
    expected = {path.removeprefix("plugins/") for path in files_in("plugins/tacos_validation")}
    assert names == expected - {"tacos_validation/pyproject.toml"}
    assert "tacos_validation/recipes/gap_blind_check.yaml" in names
    points = configparser.ConfigParser()
    points.read_string(metadata(validation_wheel, "entry_points.txt"))
    assert dict(points["tacos"]) == {"validation": "tacos_validation.plugin"}
    assert dict(points["tacos_recipes"]) == {"validation": "tacos_validation.recipes"}


def test_validation_has_the_version_of_the_framework(
    wheel: zipfile.ZipFile, validation_wheel: zipfile.ZipFile
) -> None:
    ours, its = (Parser().parsestr(metadata(each, "METADATA")) for each in (wheel, validation_wheel))
    assert its["Version"] == ours["Version"]


def test_what_validation_offers_is_told_where_it_is_missing() -> None:
    """The list of known packages names all its components and recipes, and nothing else."""
    known = json.loads((ROOT / "catalogs/plugin_packages.json").read_text())["tacos-framework[validation]"]
    assert known["components"] == sorted(component.use for component in tacos_components())
    assert known["recipes"] == sorted(path.stem for path in (VALIDATION / "recipes").glob("*.yaml"))


@pytest.mark.parametrize("name", ["gap_blind_check", "own.yaml"])
def test_without_validation_a_recipe_names_what_to_install(
    name: str, wheel: zipfile.ZipFile, tmp_path: Path
) -> None:
    site = tmp_path / "site"
    wheel.extractall(site)
    (tmp_path / "own.yaml").write_text("tacos: 1\nname: mine\nuse: procedure.gap-blind-check\n")
    code = (
        "import importlib.metadata as m, sys; found = m.entry_points;"
        "m.entry_points = lambda **k: m.EntryPoints(p for p in found(**k) if p.name != 'validation');"
        "import tacos_framework.cli as cli; sys.exit(cli.run_main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, name, "--check"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stdout + done.stderr
    assert "pip install 'tacos-framework[validation]'" in done.stdout + done.stderr


def test_licence(wheel: zipfile.ZipFile) -> None:
    fields = Parser().parsestr(metadata(wheel, "METADATA"))
    assert fields["License-Expression"] == "Apache-2.0"
    assert "Apache License" in metadata(wheel, "licenses/LICENSE")
