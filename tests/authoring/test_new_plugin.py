"""A generated project installs, is found, and passes its tests as it stands."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tacos_framework.components import KINDS
from tacos_framework.errors import UserError
from tacos_plugins.authoring.scaffold import new_plugin
from tests.fresh_environment import FreshEnvironment

RUFF = '[lint]\nselect = ["E", "W", "F", "I", "B", "UP"]\n'


def test_a_project_of_every_kind_installs_and_passes_its_tests(tmp_path: Path) -> None:
    environment = FreshEnvironment.make(tmp_path)
    environment.expect(f"tacos new-plugin tacos-foggy-day --kind {' '.join(KINDS)}")
    environment.expect("pip install --quiet --editable tacos-foggy-day")
    listed = environment.expect("tacos plugins")
    for kind in KINDS:
        assert f"{kind}.foggy-day" in listed
        assert (environment.folder / "tacos-foggy-day" / "tests" / f"test_{kind}.py").is_file()
    assert "broken" not in listed
    environment.expect("pytest -q tacos-foggy-day")


def test_a_procedure_as_generated_runs_from_a_recipe(tmp_path: Path) -> None:
    environment = FreshEnvironment.make(tmp_path)
    environment.expect("tacos new-plugin coin --kind procedure")
    environment.expect("pip install --quiet ./coin")
    (environment.folder / "toss.yaml").write_text("tacos: 1\nname: toss\nuse: procedure.coin\ntosses: 10\n")
    assert "of 10 tosses were heads" in environment.expect("tacos-run toss.yaml --quiet --out run")


@pytest.mark.parametrize("kind", KINDS)
def test_a_project_of_one_kind_is_tidy(kind: str, tmp_path: Path) -> None:
    ruff = pytest.importorskip("ruff", reason="ruff comes with the extra lint")
    new_plugin("tacos-fog", [kind], folder=tmp_path)
    (tmp_path / "ruff.toml").write_text(f"line-length = 110\nsrc = ['tacos-fog/src']\n{RUFF}")
    for command in (["check"], ["format", "--check"]):
        done = subprocess.run(
            [sys.executable, "-m", ruff.__name__, *command, "--no-cache", str(tmp_path / "tacos-fog")],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout
    texts = [path.read_text() for path in (tmp_path / "tacos-fog").rglob("*") if path.is_file()]
    assert not any("{{" in text for text in texts)


def test_only_the_kinds_asked_for_are_written(tmp_path: Path) -> None:
    written = new_plugin("fog", ["effect", "sensor", "effect"], folder=tmp_path)
    assert {path.name for path in written if path.parent.name == "fog"} == {
        *("pyproject.toml", "README.md", ".gitignore"),
        *("__init__.py", "plugin.py", "effect.py", "sensor.py"),
    }
    assert "FogEffect" in (tmp_path / "fog/src/fog/plugin.py").read_text()


@pytest.mark.parametrize(
    ("name", "kinds", "said"),
    [
        ("Fog", ["task"], "'Fog': is no name for a plugin"),
        ("my_fog", ["task"], "is no name for a plugin"),
        ("tacos-", ["task"], "is no name for a plugin"),
        ("tacos-3d", ["task"], "is no name for a plugin"),
        ("../fog", ["task"], "is no name for a plugin"),
        ("json", ["task"], "its package 'json' would hide a module"),
        ("tacos-framework", ["task"], "Call it tacos-framework-plugin"),
        ("class", ["task"], "its package 'class' would hide a module"),
        ("fog", ["efect"], "Did you mean 'effect'?"),
        ("fog", [], "no kind is named"),
    ],
)
def test_nonsense_is_refused_in_a_sentence(name: str, kinds: list[str], said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=said.replace("?", r"\?")):
        new_plugin(name, kinds, folder=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_folder_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "fog").mkdir()
    (tmp_path / "fog" / "precious").write_text("mine")
    with pytest.raises(UserError, match="is there already"):
        new_plugin("fog", folder=tmp_path)
    assert (tmp_path / "fog" / "precious").read_text() == "mine"
    assert len(list((tmp_path / "fog").iterdir())) == 1
