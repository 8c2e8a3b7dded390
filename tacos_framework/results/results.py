"""The results folder of a run: what stands where, written so that a killed run can go on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tacos_framework.errors import Fault, UserError
from tacos_framework.results.checksums import (
    Damaged,
    checked_json,
    checked_text,
    text_with_checksum,
)
from tacos_framework.results.differences import differences
from tacos_framework.results.folder import RunFolder
from tacos_framework.results.reading import (
    MANIFEST,
    RESULT,
    damage,
    file_of_run,
    read_run_json,
    read_run_text,
)
from tacos_framework.results.writing import PARTIAL
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_framework.settings.yaml_writer import to_yaml

FORMAT = 4
"""Format of ``checkpoint.json``; another one cannot be resumed."""

RECIPE, CHECKPOINT, LOG = "recipe.yaml", "checkpoint.json", "log.txt"

_ANOTHER = "Name another folder with --out."


def _as_it_is(recipe: Mapping[str, Any]) -> Mapping[str, Any]:
    return recipe


class Results(RunFolder):
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

    @classmethod
    def create(cls, folder: Path, recipe: Mapping[str, Any], *, resumable: bool = False) -> Results:
        """Start a new run in a folder that does not exist yet or holds nothing that a run computed.

        Parameters
        ----------
        folder
            That of the run.
        resumable
            Whether a run of it can be gone on with from its recipe alone, without a checkpoint.

        Raises
        ------
        UserError
            When something is there already, or the folder cannot be written.
        """
        with _closed_on_error(cls(folder)) as results:
            with results.writing(remedy=_ANOTHER):
                if results.folder.is_file():
                    raise UserError(Fault(str(folder), "this is a file", "a new folder", _ANOTHER))
                results.folder.mkdir(parents=True, exist_ok=True)
                results._hold()
                if results._empty():
                    results._write_recipe(recipe)
                    return results
            there = {path.name for path in results.folder.iterdir()}
            broken = CHECKPOINT in there or (resumable and RECIPE in there and RESULT not in there)
            remedy = "Go on with it by --resume, or name another with --out." if broken else _ANOTHER
            raise UserError(Fault(str(folder), "the results folder is not empty", "a new folder", remedy))

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
        with _closed_on_error(cls(folder)) as results:
            return results, results._checkpoint_of(recipe, comparable)

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
        elsewhere = {"executor": None}  # where it runs may change
        differing = list(differences({**kept, **elsewhere}, {**wanted, **elsewhere}))
        if differing:
            raise UserError(
                Fault(
                    str(folder),
                    f"it holds a run of another recipe: {difference}",
                    "the recipe and --set it was started with",
                    "Resume with those, or name another --out.",
                )
                for difference in differing
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
        """Whether nothing is there but what a run leaves that ended before it had computed anything."""
        names = {path.name for path in self.folder.iterdir() if not path.name.endswith(PARTIAL)}
        if not names:
            return True
        if not {RECIPE, LOG} <= names <= {RECIPE, LOG, MANIFEST}:
            return False
        try:
            checked_text(file_of_run(self.folder / RECIPE))  # of a run, not somebody's own
        except (Damaged, UserError):
            return False
        return True

    def _remove_partial_files(self) -> None:
        for folder in (self.folder, self.folder / "weights", self.folder / "samples"):
            for path in folder.glob(f"*{PARTIAL}"):
                path.unlink()

    def _write_recipe(self, recipe: Mapping[str, Any]) -> None:
        self.write_text(RECIPE, text_with_checksum(to_yaml(dict(recipe))))

    def write_checkpoint(self, state: Mapping[str, Any]) -> None:
        """Replace the checkpoint."""
        self.write_json(CHECKPOINT, {"format": FORMAT, **state})


def read_recipe(folder: Path) -> dict[str, Any]:
    """The resolved recipe of the run in a folder.

    Raises
    ------
    UserError
        When it cannot be read, or is not as the run left it.
    """
    path = folder / RECIPE
    text = read_run_text(path)
    try:
        recipe = read_yaml(text, RECIPE, aliases=True).data
    except UserError as error:
        first = error.faults[0]
        raise UserError(damage(path, f"{first.where}: {first.what}")) from error
    if not isinstance(recipe, dict):
        raise UserError(damage(path, "it is no recipe"))
    return recipe


@contextmanager
def _closed_on_error(results: Results) -> Iterator[Results]:
    """Let others in again where a run could not begin, whatever kept it."""
    try:
        yield results
    except BaseException:
        results.close()
        raise


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
