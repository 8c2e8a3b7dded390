"""Plugins gone wild, as users meet them: named, and the host goes on, or says why it cannot."""

from __future__ import annotations

import locale
import os
import random
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
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


@pytest.fixture
def short(monkeypatch):
    """Imports may take 0.1 s of processor time, 1 s by the clock: those of the plugins that ship are over."""
    Plugins.discover()
    monkeypatch.setenv("TACOS_IMPORT_S", "0.1")


@pytest.mark.parametrize(
    ("source", "said"),
    {
        "endless": (
            "while True: pass",
            "TookTooLong: more than 0.1 s of processor time, which TACOS_IMPORT_S changes",
        ),
        "waits": ("import time; time.sleep(1000)", "TookTooLong: more than 1 s by the clock"),
        "catches once": (
            "import time\ntry:\n    while True: time.sleep(0)\nexcept BaseException:\n    time.sleep(9)",
            "TookTooLong",
        ),
        "own Ctrl-C": ("raise KeyboardInterrupt", "its import failed: KeyboardInterrupt"),
    }.values(),
)
def test_an_import_that_does_not_end_or_interrupts_is_a_failure(distribution, short, source, said):
    distribution("zz-wild", source)
    timers = signal.getitimer(signal.ITIMER_REAL), signal.getsignal(signal.SIGALRM)
    plugins = Plugins.discover()
    (failure,) = plugins.failures
    assert failure.plugin == "zz-wild"
    assert said in failure.reason
    assert plugins.component("sensor.affine-noise")
    assert timers == (signal.getitimer(signal.ITIMER_REAL), signal.getsignal(signal.SIGALRM))


@pytest.mark.parametrize("source", ["while True: pass", "raise KeyboardInterrupt"])
def test_so_is_that_of_a_component(distribution, tmp_path, monkeypatch, source):
    distribution("zz-wild", SOUND)
    (tmp_path / "zz_wild_task.py").write_text(source)
    plugins = Plugins.discover()
    monkeypatch.setenv("TACOS_IMPORT_S", "0.1")
    with pytest.raises(ImportError, match=r"zz_wild_task:Task ended the program while task\.wild was"):
        plugins.resolve("task.wild")


def test_what_was_waited_for_is_said_at_once(distribution, short, capsys):
    distribution("zz-wild", "while True: pass")
    Plugins.discover()
    said = "plugin zz-wild is not imported in 0.1 s of processor time; spare the wait"
    assert said in capsys.readouterr().err


BUSY = """
import time
began_s = time.monotonic()
while time.monotonic() - began_s < 0.5:
    time.sleep(0.05)  # so does a process that others keep from the processor
"""


def test_an_import_on_a_busy_machine_is_waited_for(distribution, short):
    distribution("zz-slow", BUSY + SOUND)
    plugins = Plugins.discover()
    assert plugins.failures == []
    assert plugins.component("task.wild")


@pytest.mark.parametrize("given", ["much", "0", "-1", "nan", "inf"])
def test_a_limit_that_is_none_is_a_fault(monkeypatch, capsys, given):
    monkeypatch.setenv("TACOS_IMPORT_S", given)
    assert tacos_main(["plugins"]) == 2
    assert f"TACOS_IMPORT_S: it is {given!r}" in capsys.readouterr().err


def test_a_run_lives_with_it(distribution, capsys):
    distribution("zz-wild", "raise KeyboardInterrupt")
    assert run_main(["headset_quick", "--check"]) == 0
    assert "headset_quick: no faults." in capsys.readouterr().out


def test_a_timer_of_the_host_is_left_alone(distribution, short):
    distribution(
        "zz-slow", f"import time\nwhile time.thread_time() < {time.thread_time() + 0.2}: pass\n{SOUND}"
    )
    signal.setitimer(signal.ITIMER_REAL, 1000.0)
    try:
        assert Plugins.discover().failures == []
        assert signal.getitimer(signal.ITIMER_REAL)[0] > 900.0
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def test_ctrl_c_gets_through_and_says_what_it_broke_off(distribution, capsys):
    distribution("zz-wild", CTRL_C)
    assert tacos_main(["plugins"]) == 130
    assert "Interrupted during the import of plugin zz-wild." in capsys.readouterr().err


def test_an_import_that_cannot_be_stopped_ends_with_its_name(distribution, tacos):
    catches_all = """
        import time
        while True:
            try:
                while True: time.sleep(0)
            except BaseException: pass
    """
    distribution("zz-wild", catches_all)
    done = tacos("plugins", TACOS_IMPORT_S="0.1")
    assert done.returncode == 1
    assert (
        "the import of plugin zz-wild cannot be stopped; leave it out: TACOS_WITHOUT=zz-wild" in done.stderr
    )


@pytest.mark.parametrize("ends", ["os._exit(0)", "os.abort()"])
def test_the_next_start_names_what_ended_the_last(distribution, tacos, tmp_path, ends):
    distribution("zz-wild", f"import os; {ends}")
    cache = {"TACOS_CACHE": str(tmp_path / "cache")}
    assert tacos("plugins", **cache).stdout == "", "nothing survives this, and nothing can be said"
    said = (
        "ended while plugin zz-wild was imported. Should this one, too, leave it out: TACOS_WITHOUT=zz-wild"
    )
    assert said in tacos("plugins", **cache).stderr
    done = tacos("plugins", **cache, TACOS_WITHOUT="zz-wild")
    assert done.returncode == 0
    assert "renderer.moderngl" in done.stdout
    assert "plugin zz-wild: TACOS_WITHOUT names it, so it is left out" in done.stderr
    assert list((tmp_path / "cache" / "importing").iterdir()) == [], "it is said once"


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


UNDONE = {
    "import os; os.chdir('/')": "the working directory",
    "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)": "handlers of signals",
    "import signal; signal.signal(signal.SIGCHLD, lambda *_: None)": "handlers of signals",
    "import random; random.seed(1)": "the state of random",
    "import numpy; numpy.seterr(all='raise')": "how numpy takes errors",
    "import warnings; warnings.simplefilter('ignore')": "the filters of warnings, to hide all",
    "import os; os.environ.update(ZZ_KNOWN='b')": "the environment",
    "import os; del os.environ['ZZ_KNOWN']": "the environment",
    "import os; os.environ['TACOS_LIMITS'] = 'text_mb=9'": "the environment, which was undone: TACOS_LIMITS",
    "import sys; sys.path.clear()": "folders out of sys.path",
    "import locale; locale.setlocale(locale.LC_ALL, 'C' if locale.setlocale(locale.LC_ALL) != 'C' "
    "else 'C.UTF-8')": "the locale",
}


def state_of_the_process() -> list[object]:
    handlers = [signal.getsignal(number) for number in signal.valid_signals()]
    process = [os.getcwd(), dict(os.environ), list(sys.path), locale.setlocale(locale.LC_ALL)]
    return [*process, handlers, random.getstate(), np.geterr(), list(warnings.filters)]


@pytest.mark.parametrize(("source", "what"), UNDONE.items())
def test_what_an_import_changes_is_undone_and_said(distribution, monkeypatch, capsys, source, what):
    monkeypatch.setenv("ZZ_KNOWN", "a")
    distribution("zz-wild", f"{source}\n{SOUND}")
    before = state_of_the_process()
    plugins = Plugins.discover()
    assert state_of_the_process() == before
    (remark,) = plugins.remarks
    assert remark.name == "plugin zz-wild"
    assert what in remark.value
    assert "undone" in remark.value
    assert plugins.component("task.wild"), "the plugin itself is used"
    monkeypatch.delitem(sys.modules, "zz_wild")
    assert tacos_main(["plugins"]) == 0
    assert f"note: plugin zz-wild: {remark.value}" in capsys.readouterr().err


def test_what_an_import_adds_stays(distribution, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delenv("ZZ_NEW", raising=False)
    monkeypatch.setenv("ZZ_PATH", "/a")
    adding = "import os, sys; os.environ.update(ZZ_NEW='1', ZZ_PATH='/b:/a'); sys.path.append('/zz/vendored')"
    distribution("zz-wild", f"{adding}\n{SOUND}")
    said = [remark.value for remark in Plugins.discover().remarks]
    assert os.environ.pop("ZZ_NEW") == "1"
    assert os.environ["ZZ_PATH"] == "/b:/a"
    assert said == ["its import added to sys.path: /zz/vendored"]


def test_a_thread_left_behind_is_named_and_keeps_nobody_from_ending(distribution, tacos):
    waits = "import threading; threading.Thread(target=threading.Event().wait, name='drain').start()"
    distribution("zz-wild", f"{waits}\n{SOUND}")
    done = tacos("plugins")
    assert done.returncode == 0
    assert "plugin zz-wild: its import left a thread running" in done.stderr
    assert "keeps programs from ending: drain" in done.stderr
    assert "ended without waiting for threads that were left by plugin zz-wild" in done.stderr


def test_marks_do_not_stay(distribution, tmp_path, monkeypatch):
    monkeypatch.setenv("TACOS_CACHE", str(tmp_path / "cache"))
    distribution("zz-wild", "raise RuntimeError")
    assert Plugins.discover().failures
    assert list((tmp_path / "cache" / "importing").iterdir()) == []
