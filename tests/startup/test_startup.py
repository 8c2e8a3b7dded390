"""Listing plugins and printing help must be quick: heavy libraries are imported where they are used."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = (
    "numpy",
    "scipy",
    "cv2",
    "networkx",
    "torch",
    "moderngl",
    "trimesh",
    "matplotlib",
    "colour",
    "shapely",
)

_PROBE = """
import sys
try:
    {code}
except SystemExit as ended:
    assert not ended.code, f"ended with {{ended.code}}"
heavy = sorted(set({heavy!r}) & set(sys.modules))
print("\\nheavy:", ",".join(heavy))
"""


def heavy_imports(code: str) -> str:
    """The heavy libraries a fresh interpreter has imported after `code`, joined by commas."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", _PROBE.format(code=code, heavy=HEAVY)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.rpartition("heavy:")[2].strip()


@pytest.mark.parametrize(
    "code",
    [
        "import tacos_framework",
        "import tacos",
        "from tacos_framework.plugins import Plugins; assert list(Plugins.discover())",
        "from tacos_framework.cli import run_main; sys.argv = ['tacos-run', '--help']; sys.exit(run_main())",
        "from tacos_framework.cli import tacos_main; sys.argv = ['tacos', '--help']; sys.exit(tacos_main())",
        "from tacos_framework.cli import tacos_main; sys.argv = ['tacos', 'plugins']; sys.exit(tacos_main())",
    ],
    ids=["import", "import tacos", "discover", "tacos-run --help", "tacos --help", "tacos plugins"],
)
def test_starts_without_heavy_libraries(code: str) -> None:
    assert heavy_imports(code) == ""


def test_the_probe_sees_heavy_libraries() -> None:
    assert heavy_imports("import numpy") == "numpy"


def test_checking_the_demo_imports_no_library_that_only_a_run_needs() -> None:
    code = "from tacos_framework.cli import run_main; assert run_main(['headset_quick', '--check']) == 0"
    heavy = set(heavy_imports(code).split(","))
    assert not heavy & {"scipy", "torch", "trimesh", "matplotlib", "colour", "shapely"}
