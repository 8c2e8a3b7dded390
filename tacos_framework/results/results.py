"""The results folder of a run: what stands where, written so that a killed run can go on."""

from __future__ import annotations

import errno
import fcntl
import json
import logging
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from safetensors.numpy import load_file, save

from tacos_framework.contracts import State
from tacos_framework.errors import Fault, UserError
from tacos_framework.settings.yaml_writer import to_yaml

log = logging.getLogger(__name__)

FORMAT = 3
"""Format of ``checkpoint.json``; another one cannot be resumed."""

PARTIAL = ".partial"
"""Ends the names of files that are being written; what is left of them after a crash counts for nothing."""


class Results:
    """A folder that holds one run, and is this process's alone until `close`; usable with ``with``.

    ======================  ===========================================================================
    ``recipe.yaml``         the resolved recipe, every default filled in
    ``generations.jsonl``   one line per generation of the design
    ``result.json``         what came out
    ``report.html``         the same, to look at
    ``weights/``            states of trainable tasks (safetensors)
    ``samples/``            sample frames (PNG)
    ``checkpoint.json``     what ``--resume`` goes on from
    ``log.txt``             what happened, with times
    ======================  ===========================================================================
    """

    def __init__(self, folder: Path):
        self.folder = Path(folder)
        self._lock: int | None = None

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
            resumable = (results.folder / "checkpoint.json").exists()
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
    def resume(cls, folder: Path, recipe: Mapping[str, Any]) -> tuple[Results, dict[str, Any] | None]:
        """Go on with a run: the folder and its last checkpoint, None when it had not got that far.

        Raises
        ------
        UserError
            When there is no run there, or it is one of another recipe.
        """
        results = cls(folder)
        try:
            state = results._checkpoint_of(recipe)
        except UserError:
            results.close()
            raise
        return results, state

    def _checkpoint_of(self, recipe: Mapping[str, Any]) -> dict[str, Any] | None:
        """The last checkpoint of the run in the folder, which must be of this recipe."""
        folder, begun = self.folder, self.folder / "recipe.yaml"
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
            if not begun.exists():  # the run ended before it had begun
                self._write_recipe(recipe)
                return None
        earlier = _read(begun, lambda text: dict(yaml.safe_load(text)))
        differing = [
            key for key in {*earlier, *recipe} if earlier.get(key) != recipe.get(key) and key != "executor"
        ]
        if differing:
            raise UserError(
                Fault(
                    str(folder),
                    f"it holds a run of another recipe: {', '.join(sorted(differing))} differ",
                    "the recipe and --set it was started with",
                    "Resume with those, or name another --out.",
                )
            )
        checkpoint = folder / "checkpoint.json"
        if not checkpoint.exists():
            return None
        state = _read(checkpoint, lambda text: dict(json.loads(text)))
        if state.get("format") != FORMAT:
            raise UserError(
                Fault(
                    str(checkpoint),
                    f"it is of another version of tacos-framework: format {state.get('format')}",
                    f"format {FORMAT}",
                    "Resume with the version of tacos-framework it was written by.",
                )
            )
        return state

    # the folder -------------------------------------------------------------------------------------------

    def _empty(self) -> bool:
        """Whether nothing is there but what a run leaves that was killed before it had begun."""
        return all(path.name.endswith(PARTIAL) for path in self.folder.iterdir())

    def _write_recipe(self, recipe: Mapping[str, Any]) -> None:
        self.write_text("recipe.yaml", to_yaml(dict(recipe)))

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

    @contextmanager
    def logging(self, packages: Iterable[str]) -> Iterator[None]:
        """Write the log of these packages to ``log.txt`` meanwhile."""
        with self.writing():
            handler = _LogFile(self.folder / "log.txt", encoding="utf-8")
        handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
        loggers = [logging.getLogger(name) for name in sorted(set(packages))]
        for logger in loggers:
            logger.addHandler(handler)
            logger.setLevel(logging.INFO)
        try:
            yield
        finally:
            for logger in loggers:
                logger.removeHandler(handler)
            handler.close()

    def write_text(self, name: str, text: str) -> Path:
        """Write a file whole or not at all."""
        return self._write(name, text.encode("utf-8"))

    def write_json(self, name: str, value: Any) -> Path:
        """Write plain data as JSON, whole or not at all; NaN is refused."""
        return self.write_text(name, json.dumps(value, indent=1, allow_nan=False, ensure_ascii=False) + "\n")

    def _write(self, name: str, data: bytes) -> Path:
        path = self.folder / name
        with self.writing():
            if not self.folder.is_dir():
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(self.folder))
            path.parent.mkdir(parents=True, exist_ok=True)
            partial = path.with_name(path.name + PARTIAL)
            try:
                with partial.open("wb") as file:
                    file.write(data)
                    _to_disk(file.fileno())
            except OSError:
                partial.unlink(missing_ok=True)  # a full disk needs the room
                raise
            partial.replace(path)
            folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
            try:
                _to_disk(folder)
            finally:
                os.close(folder)
        return path

    def write_checkpoint(self, state: Mapping[str, Any]) -> None:
        """Replace the checkpoint."""
        self.write_json("checkpoint.json", {"format": FORMAT, **state})

    def write_lines(self, name: str, lines: Iterable[Any]) -> None:
        """Replace a file of JSON lines."""
        self.write_text(
            name, "".join(json.dumps(line, allow_nan=False, ensure_ascii=False) + "\n" for line in lines)
        )

    def append_line(self, name: str, line: Any) -> None:
        """Add one JSON line to a file."""
        text = json.dumps(line, allow_nan=False, ensure_ascii=False) + "\n"
        with self.writing(), (self.folder / name).open("a", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            _to_disk(file.fileno())

    def read_lines(self, name: str) -> list[Any]:
        """The JSON lines of a file; empty when it is not there. A last line cut short is left out."""
        path = self.folder / name
        if not path.exists():
            return []
        whole, _, _ = path.read_text("utf-8").rpartition("\n")
        return [json.loads(line) for line in whole.splitlines()]

    def write_state(self, name: str, state: State, about: Mapping[str, str] | None = None) -> None:
        """Keep the state of a trainable task under ``weights/``; `about` goes into the file's header."""
        arrays = {key: np.ascontiguousarray(value) for key, value in state.items()}
        self._write(f"weights/{name}.safetensors", save(arrays, metadata=dict(about) if about else None))

    def read_state(self, name: str) -> State:
        """A state kept by `write_state`."""
        return load_file(self.folder / "weights" / f"{name}.safetensors")

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
        return relative


def _to_disk(descriptor: int) -> None:
    """Have the system write out what it holds back, so that it outlives the machine's power."""
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # file systems that cannot, for folders
            raise


def _read(path: Path, parse: Callable[[str], dict[str, Any]]) -> dict[str, Any]:
    """What a file of the run holds, or what is wrong with it."""
    try:
        return parse(path.read_text("utf-8"))
    except (OSError, ValueError, TypeError, yaml.YAMLError) as error:
        raise UserError(
            Fault(
                str(path),
                f"the file cannot be read: {error}",
                "the file as the run left it",
                "Start a new run.",
            )
        ) from error


class _LogFile(logging.FileHandler):
    """A log that goes quiet where it cannot be written; the run says what is wrong, and the log need not."""

    def handleError(self, record: logging.LogRecord) -> None:
        """Drop the line."""
