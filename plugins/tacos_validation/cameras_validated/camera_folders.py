"""Captures of several cameras: a folder with a folder for each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tacos_framework import Fault, Plugins, UserError
from tacos_gap.captures import CaptureFolder, read_captures
from tacos_gap.captures.missing import FILE
from tacos_gap.simulation.bench import recipe_renderer

PATCH = "patched.yaml"
"""What a diagnosis leaves of its causes."""

Read = Callable[[Path], CaptureFolder]


def camera_folders(folder: str | Path, *, patched: bool = False) -> dict[str, Path]:
    """The folders of captures in a folder, by name; each is a camera.

    `patched`: true if each must hold a ``patched.yaml``. Raises UserError when there are fewer than two, or a
    patch is missing.
    """
    path = Path(folder)
    if not path.is_dir():
        raise UserError(Fault(str(path), "there is no such folder", "a folder with a folder for each camera"))
    found = {each.name: each for each in sorted(path.iterdir()) if (each / FILE).is_file()}
    faults = []
    if len(found) < 2:
        what = (
            f"{len(found)} of its folders holds a {FILE}" if found else f"none of its folders holds a {FILE}"
        )
        wanted = "two cameras or more, as one cannot be ranked"
        faults.append(Fault(str(path), what, wanted, "See the how-to on captures."))
    if patched:
        faults += [
            Fault(str(each / PATCH), "there is no such file", "what a diagnosis of the camera left")
            for each in found.values()
            if not (each / PATCH).is_file()
        ]
    if faults:
        raise UserError(faults)
    return found


def read_cameras(folders: dict[str, Path], plugins: Plugins) -> dict[str, CaptureFolder]:
    """The captures of every camera. Raises UserError with the faults of all of them."""
    cameras, faults = {}, list[Fault]()
    render = recipe_renderer(plugins)
    for name, path in folders.items():
        try:
            cameras[name] = read_captures(path, render)
        except UserError as error:
            faults += error.faults
    if faults:
        raise UserError(faults)
    return cameras
