"""The results folder of a run: what stands where, written so that a killed run can go on."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from safetensors.numpy import load_file, save_file

from tacos_framework.contracts import State
from tacos_framework.errors import Fault, UserError

FORMAT = 1
"""Format of ``checkpoint.json``; another one cannot be resumed."""


class Results:
    """A folder that holds one run.

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

    @classmethod
    def create(cls, folder: Path, recipe: Mapping[str, Any]) -> Results:
        """Start a new run in a folder that does not exist yet or is empty.

        Raises
        ------
        UserError
            When something is there already, or the folder cannot be written.
        """
        results = cls(folder)
        try:
            results.folder.mkdir(parents=True, exist_ok=True)
            taken = any(results.folder.iterdir())
            if not taken:
                results.write_text(
                    "recipe.yaml", yaml.safe_dump(dict(recipe), sort_keys=False, allow_unicode=True)
                )
        except OSError as error:
            raise UserError(
                Fault(
                    str(folder),
                    f"the results folder cannot be written: {error.strerror}",
                    "a folder on a disk with room that you may write to",
                    "Name another folder with --out.",
                )
            ) from error
        if taken:
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
            begun = yaml.safe_load((results.folder / "recipe.yaml").read_text("utf-8"))
        except FileNotFoundError:
            raise UserError(
                Fault(
                    str(folder),
                    "there is no run to resume",
                    "a folder with recipe.yaml and checkpoint.json",
                    "Leave out --resume to start one.",
                )
            ) from None
        differing = [
            key for key in {*begun, *recipe} if begun.get(key) != recipe.get(key) and key != "executor"
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
        checkpoint = results.folder / "checkpoint.json"
        if not checkpoint.exists():
            return results, None
        state = json.loads(checkpoint.read_text("utf-8"))
        if state.get("format") != FORMAT:
            raise UserError(
                Fault(
                    str(checkpoint),
                    f"format {state.get('format')}",
                    f"format {FORMAT}",
                    "Resume with the version of tacos-framework it was written by.",
                )
            )
        return results, state

    @contextmanager
    def logging(self, packages: Iterable[str]) -> Iterator[None]:
        """Write the log of these packages to ``log.txt`` meanwhile."""
        handler = logging.FileHandler(self.folder / "log.txt", encoding="utf-8")
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
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(path.name + ".partial")
        with partial.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
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
        with (self.folder / name).open("a", encoding="utf-8") as file:
            file.write(json.dumps(line, allow_nan=False, ensure_ascii=False) + "\n")

    def read_lines(self, name: str) -> list[Any]:
        """The JSON lines of a file; empty when it is not there. A last line cut short is left out."""
        path = self.folder / name
        if not path.exists():
            return []
        whole, _, _ = path.read_text("utf-8").rpartition("\n")
        return [json.loads(line) for line in whole.splitlines()]

    def write_state(self, name: str, state: State) -> None:
        """Keep the state of a trainable task under ``weights/``."""
        path = self.folder / "weights" / f"{name}.safetensors"
        path.parent.mkdir(exist_ok=True)
        partial = path.with_suffix(".partial")
        save_file({key: np.ascontiguousarray(value) for key, value in state.items()}, partial)
        partial.replace(path)

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
