"""Blender in a process of its own."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_files.arrays import read_npy
from tacos_framework import Fault, UserError

SCRIPT = Path(__file__).with_name("inside_blender.py")
_LINES_SHOWN = 15


def refuse_without_blender() -> None:
    """Say what is missing.

    Raises `UserError` where the package bpy is not installed.
    """
    if importlib.util.find_spec("bpy") is None:
        raise UserError(
            Fault(
                "renderer.blender",
                "the package bpy (Blender as a Python module) is not installed",
                remedy="pip install tacos-framework[blender] (375 MB; each release of bpy is for one Python: "
                "5.0 for 3.11), or use renderer.mitsuba.",
            )
        )


@contextmanager
def workplace() -> Iterator[Path]:
    """A folder for one job, gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="tacos-blender-") as folder:
        yield Path(folder)


def pictures(
    folder: Path, shots: Sequence[dict[str, Any]], settings: dict[str, Any]
) -> list[NDArray[np.float32]]:
    """(H, W, 3) luminance of each shot of the scene in a folder [cd/m2].

    Raises `RuntimeError` where Blender fails, with the last lines it wrote.
    """
    (folder / "shots.json").write_text(json.dumps({**settings, "shots": list(shots)}), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(folder)],
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    files = [folder / f"picture_{number}.npy" for number in range(len(shots))]
    if done.returncode or not all(file.is_file() for file in files):
        said = "\n".join((done.stdout + done.stderr).splitlines()[-_LINES_SHOWN:])
        raise RuntimeError(f"Blender ended with {done.returncode} and these lines:\n{said}")
    return [read_npy(file) for file in files]
