"""A virtual environment of its own that sees what is installed here, and where plugins can be added."""

from __future__ import annotations

import os
import shlex
import subprocess
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path

REFUSED = "# refused"
"""Ends a command that is meant to fail with status 2."""

_SCRIPT = """#!{python}
import sys
from {module} import {function}
if __name__ == "__main__":  # spawned workers import it anew
    sys.exit({function}())
"""
_COMMANDS = {
    "pip": ("pip._internal.cli.main", "main"),
    "pytest": ("pytest", "main"),
    "tacos": ("tacos_framework.cli", "tacos_main"),
    "tacos-run": ("tacos_framework.cli", "run_main"),
}


@dataclass(frozen=True)
class FreshEnvironment:
    """Runs commands in a folder, with those of the environment on the path."""

    folder: Path
    bin: Path

    @classmethod
    def make(cls, place: Path) -> FreshEnvironment:
        """An environment and an empty folder below `place`."""
        home, folder = place / "venv", place / "work"
        venv.create(home, symlinks=True)
        scripts = home / "bin"
        (site,) = (home / "lib").glob("python*/site-packages")
        here = sysconfig.get_paths()["purelib"]
        (site / "_outer.pth").write_text(f"import site; site.addsitedir({here!r})\n")
        for name, (module, function) in _COMMANDS.items():
            script = scripts / name
            script.write_text(_SCRIPT.format(python=scripts / "python", module=module, function=function))
            script.chmod(0o755)
        folder.mkdir()
        return cls(folder, scripts)

    def run(self, line: str) -> subprocess.CompletedProcess[str]:
        """Run one command; pip takes nothing from the network."""
        environment = {
            **os.environ,
            "PATH": f"{self.bin}{os.pathsep}{os.environ['PATH']}",
            "PIP_NO_INDEX": "1",
            "PIP_NO_DEPS": "1",
            "PIP_NO_BUILD_ISOLATION": "0",  # pip reads the negation of a negation: no isolation
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        }
        return subprocess.run(
            shlex.split(line, comments=True),
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def expect(self, line: str) -> str:
        """Run one command and see it end as expected; returns what it printed."""
        done = self.run(line)
        status = 2 if line.endswith(REFUSED) else 0
        assert done.returncode == status, f"{line}\n{done.stdout}\n{done.stderr}"
        assert "Traceback" not in done.stderr
        return done.stdout + done.stderr
