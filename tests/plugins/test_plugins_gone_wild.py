"""Plugins gone wild, as users meet them: named, and the host goes on."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings

import pytest

from tacos_framework.cli import run_main, tacos_main
from tacos_framework.plugins import Plugins, calling

SOUND = """
from tacos_framework import Component, hookimpl
@hookimpl
def tacos_components():
    return [Component("task", "wild", "zz_wild_task:Task", summary="Wild.")]
"""
CTRL_C = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"


@pytest.fixture
def tacos(tmp_path):
    """Starts ``tacos`` in a process of its own, with the fake distributions of the test."""

    def start(*arguments: str, **environment: str):
        code = "from tacos_framework import cli; import sys; sys.exit(cli.tacos_main(sys.argv[1:]))"
        path = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])
        return subprocess.run(
            [sys.executable, "-c", code, *arguments],
            env={**os.environ, "PYTHONPATH": path, **environment},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )

    return start


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("raise SystemExit(0)", "its import failed: SystemExit: 0"),
        ("raise GeneratorExit", "its import failed: GeneratorExit"),
        ("class Own(BaseException): pass\nraise Own('mine')", "its import failed: Own: mine"),
        ("raise RuntimeError('no licence')", "its import failed: RuntimeError: no licence"),
    ],
)
def test_whatever_an_import_raises_is_a_failure_and_the_others_are_used(distribution, source, said):
    distribution("zz-wild", source)
    plugins = Plugins.discover()
    (failure,) = plugins.failures
    assert failure.plugin == "zz-wild"
    assert said in failure.reason
    assert plugins.component("sensor.affine-noise")


@pytest.mark.parametrize("source", ["raise SystemExit(0)", "raise GeneratorExit"])
def test_so_is_what_the_import_of_a_component_raises(distribution, tmp_path, monkeypatch, source):
    distribution("zz-wild", SOUND)
    (tmp_path / "zz_wild_task.py").write_text(source)
    monkeypatch.delitem(sys.modules, "zz_wild_task", raising=False)
    plugins = Plugins.discover()
    with pytest.raises(ImportError, match=r"zz_wild_task:Task ended the program while task\.wild was"):
        plugins.resolve("task.wild")


def test_a_run_lives_with_it(distribution, capsys):
    distribution("zz-wild", "raise SystemExit(0)")
    assert run_main(["headset_quick", "--check"]) == 0
    assert "headset_quick: no faults." in capsys.readouterr().out


def test_ctrl_c_gets_through_and_says_what_it_broke_off(distribution, capsys):
    distribution("zz-wild", CTRL_C)
    assert tacos_main(["plugins"]) == 130
    assert "Interrupted during the import of plugin zz-wild." in capsys.readouterr().err


def test_a_plugin_that_ends_the_process_can_be_left_out(distribution, tacos):
    distribution("zz-wild", "import os; os._exit(3)")
    assert tacos("plugins").returncode == 3, "nothing survives this"
    done = tacos("plugins", TACOS_WITHOUT="zz-wild")
    assert done.returncode == 0
    assert "renderer.moderngl" in done.stdout
    assert "plugin zz-wild: TACOS_WITHOUT names it, so it is left out" in done.stderr


def test_leaving_out_what_is_not_there_is_said(monkeypatch):
    monkeypatch.setenv("TACOS_WITHOUT", "acme")
    (failure,) = Plugins.discover().failures
    assert failure.reason == "TACOS_WITHOUT names it, but it is not there"


@pytest.mark.parametrize("then", ["", "\nif os.getpid() != host: raise RuntimeError"])
def test_a_copy_of_the_host_ends(distribution, tacos, tmp_path, then):
    distribution("zz-wild", f"import os; host = os.getpid(); os.fork(){then}\n{SOUND}")
    done = tacos("plugins", PYTHONWARNINGS="ignore")
    assert done.returncode == 0
    assert done.stdout.count("task.wild") == 1
    assert "the import of plugin zz-wild forked this process; the copy was ended" in done.stderr


def test_so_does_one_made_by_a_component_at_work(capfd):
    with warnings.catch_warnings(), calling("sensor.acme", "acme-cameras", "expose"):
        warnings.simplefilter("ignore", DeprecationWarning)
        copy = os.fork()
    assert os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1]) == 1
    assert "sensor.acme of acme-cameras, expose forked this process" in capfd.readouterr().err
