"""Folders that commands write into."""

from __future__ import annotations

import os
from pathlib import Path

from tacos_framework.errors import Fault, UserError


def made_folder(folder: Path) -> Path:
    """The folder, made where it is not there.

    Raises `UserError` when it cannot be made, or not be written to.
    """
    expected, remedy = "a folder that you may write to", "Name another folder."
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        file = next(path for path in (folder, *folder.parents) if path.exists())
        what = f"{file} is a file"
        raise UserError(Fault(str(folder), what, expected, remedy)) from error
    except OSError as error:
        what = f"the folder cannot be made: {error.strerror}"
        raise UserError(Fault(str(folder), what, expected, remedy)) from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise UserError(Fault(str(folder), "the folder cannot be written to", expected, remedy))
    return folder
