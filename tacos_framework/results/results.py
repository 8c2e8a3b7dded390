"""The results folder of a run: what stands where, written so that a killed run can go on."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from tacos_framework.contracts import State
from tacos_framework.errors import Fault, UserError
from tacos_framework.results.checksums import (
    Damaged,
    Lines,
    checked_json,
    checked_lines,
    checksum,
    json_with_checksum,
    line_with_checksum,
    lines_with_checksums,
    text_with_checksum,
)
from tacos_framework.results.reading import (
    checked_file,
    damage,
    file_of_run,
    read_recorded,
    read_run_json,
    read_run_text,
)
from tacos_framework.results.writing import PARTIAL, append_to_file, logging_to, replace_file
from tacos_framework.settings.yaml_writer import to_yaml

log = logging.getLogger(__name__)

FORMAT = 4
"""Format of ``checkpoint.json``; another one cannot be resumed."""

RECIPE, CHECKPOINT = "recipe.yaml", "checkpoint.json"


def _as_it_is(recipe: Mapping[str, Any]) -> Mapping[str, Any]:
    return recipe


class Results:
    """A folder that holds one run, and is this process's alone until `close`; usable with ``with``.

    ======================  ===========================================================================
    ``recipe.yaml``         the resolved recipe, every default filled in
    ``manifest.json``       the code, versions and files it was started with
    ``generations.jsonl``   one line per generation of the design
    ``result.json``         what came out
    ``report.html``         the same, to look at
    ``weights/``            states of trainable tasks (safetensors)
    ``samples/``            sample frames (PNG)
    ``checkpoint.json``     what ``--resume`` goes on from
    ``journal.jsonl``       what was evaluated since
    ``log.txt``             what happened, with times
    ======================  ===========================================================================
    """

    def __init__(self, folder: Path):
        self.folder = Path(folder)
        self.samples: dict[str, str] = {}
        self._lock: int | None = None
        self._ends: dict[str, dict[str, Any]] = {}

    def __enter__(self) -> Results:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @classmethod
    def create(cls, folder: Path, recipe: Mapping[str, Any]) -> Results:
        """Start a new run in a folder that does not exist yet or is empty.

        Raises
        ------
        UserError
            When something is there already, or the folder cannot be written.
        """
        results = cls(folder)
        with results.writing(remedy="Name another folder with --out."):
            results.folder.mkdir(parents=True, exist_ok=True)
            results._hold()
            taken = not results._empty()
            if not taken:
                results._write_recipe(recipe)
        if taken:
            results.close()
            resumable = (results.folder / CHECKPOINT).exists()
            raise UserError(
                Fault(
                    str(folder),
                    "the results folder is not empty",
                    "a new folder",
                    "Go on with it by --resume, or name another with --out."
                    if resumable
                    else "Name another folder with --out.",
                )
            )
        return results

    @classmethod
    def resume(
        cls,
        folder: Path,
        recipe: Mapping[str, Any],
        comparable: Callable[[Mapping[str, Any]], Mapping[str, Any]] = _as_it_is,
    ) -> tuple[Results, dict[str, Any] | None]:
        """Go on with a run: the folder and its last checkpoint, None when it had not got that far.

        Parameters
        ----------
        folder
            That of the run.
        recipe
            What it is to go on with; where it runs (``executor``) may have changed.
        comparable
            What of a recipe must not have changed; all of it by default.

        Raises
        ------
        UserError
            When there is no run there, it is one of another recipe, or its files are damaged.
        """
        results = cls(folder)
        try:
            state = results._checkpoint_of(recipe, comparable)
        except UserError:
            results.close()
            raise
        return results, state

    def _checkpoint_of(
        self,
        recipe: Mapping[str, Any],
        comparable: Callable[[Mapping[str, Any]], Mapping[str, Any]],
    ) -> dict[str, Any] | None:
        """The last checkpoint of the run in the folder, which must be of this recipe."""
        folder, begun = self.folder, self.folder / RECIPE
        if not folder.is_dir() or not (begun.exists() or self._empty()):
            raise UserError(
                Fault(
                    str(folder),
                    "there is no run to resume",
                    "a folder with recipe.yaml and checkpoint.json",
                    "Leave out --resume to start one.",
                )
            )
        with self.writing():
            self._hold()
            self._remove_partial_files()
            if not begun.exists():  # the run ended before it had begun
                self._write_recipe(recipe)
                return None
        earlier = read_recipe(folder)
        kept, wanted = (comparable(each) for each in (earlier, recipe))
        differing = [key for key in {*kept, *wanted} if kept.get(key) != wanted.get(key)]
        differing = sorted({*differing} - {"executor"})
        if differing:
            raise UserError(
                Fault(
                    str(folder),
                    f"it holds a run of another recipe: {', '.join(differing)} differ",
                    "the recipe and --set it was started with",
                    "Resume with those, or name another --out.",
                )
            )
        state = self._read_checkpoint()
        if any(earlier.get(key) != recipe.get(key) for key in {*earlier, *recipe} - {"executor"}):
            self._write_recipe(recipe)
        return state

    def _read_checkpoint(self) -> dict[str, Any] | None:
        path = self.folder / CHECKPOINT
        if not path.exists():
            return None
        try:
            state = checked_json(file_of_run(path))
        except Damaged as error:
            raise UserError(_earlier_format(path) or damage(path, str(error))) from error
        if state.get("format") != FORMAT:
            raise UserError(_of_format(path, state.get("format")))
        return state

    # the folder -------------------------------------------------------------------------------------------

    def _empty(self) -> bool:
        """Whether nothing is there but what a run leaves that was killed before it had begun."""
        return all(path.name.endswith(PARTIAL) for path in self.folder.iterdir())

    def _remove_partial_files(self) -> None:
        for folder in (self.folder, self.folder / "weights", self.folder / "samples"):
            for path in folder.glob(f"*{PARTIAL}"):
                path.unlink()

    def _write_recipe(self, recipe: Mapping[str, Any]) -> None:
        self.write_text(RECIPE, text_with_checksum(to_yaml(dict(recipe))))

    def _hold(self) -> None:
        """Keep other runs out; the system lets go of it when this process ends, in whatever way."""
        self._lock = os.open(self.folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise UserError(
                Fault(
                    str(self.folder),
                    "another run is writing into this folder",
                    "a separate folder for each run",
                    "Wait for it or end it, or name another folder with --out.",
                )
            ) from None
        except OSError as error:  # some network file systems have no locks
            log.warning("the results folder cannot be locked: %s", error.strerror)

    def close(self) -> None:
        """Let other runs in; safe to call twice."""
        lock, self._lock = self._lock, None
        if lock is not None:
            os.close(lock)

    @contextmanager
    def writing(
        self, remedy: str = "Make room or mend the folder, then go on with --resume."
    ) -> Iterator[None]:
        """What the system refuses inside becomes a `UserError` that says what to do.

        Files are replaced whole, so the last checkpoint stays what it was.
        """
        try:
            yield
        except OSError as error:
            if self._lock is not None and not self.folder.is_dir():
                fault = Fault(
                    str(self.folder), "the results folder was removed meanwhile", "", "Start again."
                )
            else:
                fault = Fault(
                    str(self.folder),
                    f"the results cannot be written: {error.strerror or error}",
                    "a folder on a disk with room that you may write to",
                    remedy,
                )
            raise UserError(fault) from error

    def logging(self, packages: Iterable[str]) -> AbstractContextManager[None]:
        """Write the log of these packages to ``log.txt`` meanwhile."""
        with self.writing():
            return logging_to(self.folder / "log.txt", packages)

    # files ------------------------------------------------------------------------------------------------

    def write_text(self, name: str, text: str) -> Path:
        """Write a file whole or not at all."""
        return self._write(name, text.encode("utf-8"))

    def write_json(self, name: str, value: Mapping[str, Any]) -> Path:
        """Write plain data as JSON with its checksum, whole or not at all; NaN is refused."""
        return self._write(name, json_with_checksum(value))

    def read_json(self, name: str) -> dict[str, Any] | None:
        """What `write_json` has written; None where that is not there.

        Raises
        ------
        UserError
            When it is not as it was written.
        """
        path = self.folder / name
        return checked_file(path, checked_json) if path.exists() else None

    def _write(self, name: str, data: bytes) -> Path:
        path = self.folder / name
        with self.writing():
            if not self.folder.is_dir():
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(self.folder))
            replace_file(path, data)
        return path

    def write_checkpoint(self, state: Mapping[str, Any]) -> None:
        """Replace the checkpoint."""
        self.write_json(CHECKPOINT, {"format": FORMAT, **state})

    def write_lines(self, name: str, lines: Iterable[Mapping[str, Any]]) -> None:
        """Replace a file of JSON lines."""
        self._ends.pop(name, None)
        self._write(name, lines_with_checksums(lines))

    def append_line(self, name: str, line: Mapping[str, Any]) -> None:
        """Add one JSON line to a file, which must not end in one that was cut short."""
        end = self.end_of(name)
        data, last = line_with_checksum(line, end["checksum"])
        with self.writing():
            append_to_file(self.folder / name, data)
        self._ends[name] = {"lines": end["lines"] + 1, "checksum": last}

    def end_of(self, name: str) -> dict[str, Any]:
        """How far a file of lines goes, as `Lines.end` has it."""
        if name not in self._ends:
            self._ends[name] = self.lines_of(name).end
        return self._ends[name]

    def lines_of(self, name: str) -> Lines:
        """The lines of a file with their checksums; none when it is not there.

        Raises
        ------
        UserError
            When one is damaged; a last line cut short is none.
        """
        path = self.folder / name
        return checked_file(path, checked_lines) if path.exists() else Lines()

    def read_lines(self, name: str) -> list[Any]:
        """The JSON lines of a file; empty when it is not there. One that was cut short is left out."""
        lines = self.lines_of(name)
        if lines.torn:
            log.warning("%s: the last line was cut short and is left out", name)
        return list(lines.values)

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        self._ends.pop(name, None)
        with self.writing():
            (self.folder / name).unlink(missing_ok=True)

    def write_state(self, name: str, state: State, about: Mapping[str, str] | None = None) -> str:
        """Keep the state of a trainable task under ``weights/``; returns its checksum.

        Parameters
        ----------
        name
            That of the file, without its ending.
        state
            What the task knows.
        about
            Goes into the file's header.
        """
        arrays = {key: np.ascontiguousarray(value) for key, value in state.items()}
        data = save(arrays, metadata=dict(about) if about else None)
        self._write(f"weights/{name}.safetensors", data)
        return checksum(data)

    def read_state(self, name: str, recorded: str) -> State:
        """A state kept by `write_state`, which has returned the checksum.

        Raises
        ------
        UserError
            When the file is not as it was written.
        """
        path = self.folder / "weights" / f"{name}.safetensors"
        data = read_recorded(path, recorded)
        try:
            return load(data)
        except SafetensorError as error:  # a checksum that fits is no proof of good will
            raise UserError(damage(path, f"it holds no weights: {error}")) from error

    def keep_weights(self, names: Iterable[str]) -> None:
        """Remove states under ``weights/`` that no checkpoint needs any more."""
        kept = {f"{name}.safetensors" for name in names}
        for path in (self.folder / "weights").glob("*.safetensors"):
            if path.name not in kept:
                path.unlink()

    def write_sample(self, name: str, image: NDArray[np.uint8]) -> str:
        """Write an (H, W, 3) uint8 RGB picture to ``samples/NAME.png``; returns its relative path."""
        import cv2

        encoded, data = cv2.imencode(".png", np.ascontiguousarray(image[..., ::-1]))
        if not encoded:
            raise ValueError(f"picture {name!r} of shape {image.shape} could not be encoded as PNG")
        relative = f"samples/{name}.png"
        self._write(relative, data.tobytes())
        self.samples[relative] = checksum(data.tobytes())
        return relative


def read_recipe(folder: Path) -> dict[str, Any]:
    """The resolved recipe of the run in a folder.

    Raises
    ------
    UserError
        When it cannot be read, or is not as the run left it.
    """
    path = folder / RECIPE
    try:
        recipe = yaml.safe_load(read_run_text(path))
    except (yaml.YAMLError, RecursionError) as error:
        raise UserError(damage(path, f"it is no YAML: {error}")) from error
    if not isinstance(recipe, dict):
        raise UserError(damage(path, "it is no recipe"))
    return recipe


def _earlier_format(path: Path) -> Fault | None:
    """What to say of a checkpoint of before there were checksums; None where it is no such thing."""
    try:
        state = read_run_json(path)
    except UserError:
        return None
    return _of_format(path, state["format"]) if state.get("format", FORMAT) != FORMAT else None


def _of_format(path: Path, given: Any) -> Fault:
    return Fault(
        str(path),
        f"it is of another version of tacos-framework: format {given}",
        f"format {FORMAT}",
        "Resume with the version of tacos-framework it was written by.",
    )
