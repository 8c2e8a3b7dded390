"""Broken plugins as users have them: listed, in nobody's way, and named where they are needed."""

from __future__ import annotations

import sys

import pytest

from tacos_framework.cli import run_main, tacos_main
from tacos_framework.plugins import Plugins

RECIPE = """\
tacos: 1
name: small
rig: {use: rig.monocular}
design:
  focal_length_mm: {between: [2, 8]}
  sensor: {from: image_sensors}
nodes:
  world: {use: scene.indoor, frames: 2}
  capture: {use: renderer.analytic, in: {episode: world}}
  frames: {use: sensor.affine-noise, in: {capture: capture}}
  judge: {use: task.NAME, in: {frames: frames}}
fitness: [{score: judge.SCORE, weight: 1}]
optimizer: {use: optimizer.random}
"""

OFFER = """
    from tacos_framework import Component, hookimpl
    @hookimpl
    def tacos_components():
        return RETURNED
"""


def offering(component: str) -> str:
    """A plugin whose hook returns an expression."""
    return OFFER.replace("RETURNED", component)


SOUND = offering('[Component("task", "broken", "zz_broken:Task", summary="Broken.")]')

AT_DISCOVERY = {
    "bad import": ("import not_there_at_all", "No module named 'not_there_at_all'"),
    "raises": ("raise RuntimeError('no licence')", "RuntimeError: no licence"),
    "exits": ("import sys; sys.exit('no licence')", "SystemExit: no licence"),
    "skips": ("import pytest; pytest.skip('not here', allow_module_level=True)", "Skipped: not here"),
    "wrong type": (offering("['task.broken']"), "it offers a str where a Component is expected"),
    "no list": (offering("7"), "TypeError: 'int' object is not iterable"),
    "exits later": (offering("exit(3)"), "SystemExit: 3"),
    "no hook": (SOUND.replace("@hookimpl", ""), "it implements no hook"),
    "empty": ("x = 1", "it implements no hook"),
    "other contract": (SOUND.replace("summary", "contract=99, summary"), "is written for contract 99"),
}

WHEN_NEEDED = {
    "no verb": ("class Task:\n        pass\n", "Task has no method begin"),
    "no class": ("", "module 'zz_broken' has no attribute 'Task'"),
}


@pytest.fixture
def recipe(tmp_path):
    def write(task: str, score: str) -> str:
        path = tmp_path / f"{task}.yaml"
        path.write_text(RECIPE.replace("NAME", task).replace("SCORE", score))
        return str(path)

    return write


@pytest.mark.parametrize(("source", "said"), AT_DISCOVERY.values(), ids=AT_DISCOVERY)
def test_the_commands_live_with_a_broken_plugin(distribution, recipe, capsys, source, said):
    distribution("zz-broken", source)
    assert tacos_main(["plugins"]) == 0
    printed = capsys.readouterr()
    assert "broken: plugin zz-broken: " in printed.err
    assert said in printed.err
    assert "renderer.moderngl" in printed.out
    assert run_main([recipe("orb-features", "inliers"), "--check"]) == 0
    capsys.readouterr()
    assert run_main([recipe("broken", "score"), "--check"]) == 2
    printed = capsys.readouterr()
    assert "no component 'task.broken' is installed" in printed.err
    assert "plugin zz-broken is unusable" in printed.err
    assert "Traceback" not in printed.err


def test_the_doctor_names_broken_plugins_and_fails(distribution, capsys):
    distribution("zz-broken", "import not_there_at_all")
    assert tacos_main(["doctor"]) == 1
    assert "BAD  plugin zz-broken: its import failed" in capsys.readouterr().out


@pytest.mark.parametrize(("source", "said"), WHEN_NEEDED.values(), ids=WHEN_NEEDED)
def test_a_component_that_does_not_fit_is_found_by_the_doctor(distribution, recipe, capsys, source, said):
    distribution("zz-broken", f"{SOUND}\n    {source}")
    assert tacos_main(["plugins"]) == 0, "listing imports no component, so nothing is wrong yet"
    assert "task.broken" in capsys.readouterr().out
    assert run_main([recipe("orb-features", "inliers"), "--check"]) == 0
    assert tacos_main(["doctor"]) == 1
    assert said in capsys.readouterr().out


def test_a_recipe_that_needs_a_class_without_its_verb_says_so(distribution, recipe, capsys):
    distribution("zz-broken", f"{SOUND}\n    class Task:\n        pass")
    assert run_main([recipe("broken", "score"), "--check"]) == 2
    assert "task.broken: Task has no method begin" in capsys.readouterr().err


def test_a_component_whose_import_ends_the_program_does_not(distribution, tmp_path, monkeypatch):
    distribution("zz-broken", SOUND.replace("zz_broken:Task", "zz_exits:Task"))
    (tmp_path / "zz_exits.py").write_text("raise SystemExit(0)")
    monkeypatch.delitem(sys.modules, "zz_exits", raising=False)
    plugins = Plugins.discover()
    with pytest.raises(ImportError, match=r"ended the program while task\.broken was imported"):
        plugins.resolve("task.broken")
    (failure,) = plugins.unusable()
    assert failure.uses == ("task.broken",)


def test_entry_points_of_equal_names_do_not_clash(distribution):
    for name in ("first", "second"):
        source = SOUND.replace('"broken"', f'"{name}"')
        distribution(f"zz-{name}", source, entry_point=f"plugin = zz_{name}")
    plugins = Plugins.discover()
    assert plugins.failures == []
    assert {"task.first", "task.second"} <= {found.component.use for found in plugins}


def test_an_entry_point_that_names_nothing_is_kept(distribution):
    distribution("zz-broken", SOUND, entry_point="broken = zz_broken:not_there")
    (failure,) = Plugins.discover().failures
    assert "has no attribute 'not_there'" in failure.reason


def test_metadata_that_was_half_uninstalled_is_survived(distribution):
    distribution("zz-broken", SOUND, metadata=False)
    plugins = Plugins.discover()
    assert "renderer.moderngl" in {found.component.use for found in plugins}


def test_nothing_that_ships_is_unusable():
    assert Plugins.discover().unusable() == []
