"""The results folder of a run: what stands where, written so that a killed run can go on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tacos_framework.errors import Fault, UserError
from tacos_framework.settings.yaml_reader import read_yaml
from tacos_framework.settings.yaml_writer import to_yaml
from tacos_framework.store.database import DATABASE, PAGE_BYTES, PARTS, Database, damage, other_version
from tacos_framework.store.differences import differences
from tacos_framework.store.folder import RunFolder
from tacos_framework.store.readers import FILES, RESULT, read_run_file
from tacos_framework.store.writers import PARTIAL

RECIPE, MANIFEST, LOG = "recipe.yaml", "manifest.json", "log.txt"

CHECKPOINT = "checkpoint"
"""Kind of the entry of the database that says how far a study has come."""

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
    ``run.sqlite``          what ``--resume`` goes on from, and digests of the files
    ``log.txt``             what happened, with times
    ======================  ===========================================================================
    """

    @classmethod
    def create(cls, folder: Path, recipe: Mapping[str, Any], *, resumable: bool = False) -> Results:
        """Start a new run in a folder that does not exist yet or holds nothing that a run computed.

        `resumable`: whether a run of it can be gone on with from its recipe alone, without a checkpoint.

        Raises `UserError` when something is there already, or the folder cannot be written.
        """
        with _closed_on_error(cls(folder)) as results:
            with results.writing(remedy=_ANOTHER):
                if results.folder.is_file():
                    raise UserError(Fault(str(folder), "this is a file", "a new folder", _ANOTHER))
                results.folder.mkdir(parents=True, exist_ok=True)
                results._hold()
                if results._empty():
                    results._begin(recipe)
                    return results
            there = {path.name for path in results.folder.iterdir()}
            kinds = results._kinds()
            computing = resumable and kinds is not None and RESULT not in there
            broken = computing or CHECKPOINT in (kinds or ())
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

        `recipe`: what it is to go on with; where it runs (``executor``) may have changed. `comparable`: what
        of a recipe must not have changed; all of it by default.

        Raises `UserError` when there is no run there, it is one of another recipe, or its files are damaged.
        """
        with _closed_on_error(cls(folder)) as results:
            return results, results._checkpoint_of(recipe, comparable)

    def _checkpoint_of(
        self, recipe: Mapping[str, Any], comparable: Callable[[Mapping[str, Any]], Mapping[str, Any]]
    ) -> dict[str, Any] | None:
        """The last checkpoint of the run in the folder, which must be of this recipe."""
        folder, begun = self.folder, self.folder / RECIPE
        if not folder.is_dir() or not (begun.exists() or self._empty()):
            raise UserError(
                Fault(
                    str(folder),
                    "there is no run to resume",
                    "a folder with recipe.yaml and run.sqlite",
                    "Leave out --resume to start one.",
                )
            )
        with self.writing():
            self._hold()
            self._remove_partial_files()
            if not begun.exists():  # the run ended before it had begun
                self._begin(recipe)
                return None
            self._database = self._opened()
        self._database.check()
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
        if any(earlier.get(key) != recipe.get(key) for key in {*earlier, *recipe} - {"executor"}):
            self._write_recipe(recipe)
        for name in (kind for kind in self._database.kinds() if kind.endswith(".jsonl")):
            self.write_lines(name, self.read_lines(name))  # whoever was killed may have written half a line
        checkpoint: dict[str, Any] | None = self._database.get(CHECKPOINT, 0)
        return checkpoint

    def _opened(self) -> Database:
        path = self.folder / DATABASE
        if path.exists():
            return Database(path)
        if (self.folder / "checkpoint.json").exists():
            raise UserError(other_version(self.folder, "it has a checkpoint.json", f"a {DATABASE}"))
        raise UserError(damage(path, "it is not there"))

    # the folder -------------------------------------------------------------------------------------------

    def _empty(self) -> bool:
        """True if the folder only holds leftovers of a run that ended before it had computed anything."""
        names = {path.name for path in self.folder.iterdir() if not path.name.endswith(PARTIAL)} - {*PARTS}
        kinds, database = self._kinds(), self.folder / DATABASE
        if not names and kinds is None:  # whoever was killed as it made the database has left one page of it
            return not database.exists() or database.stat().st_size <= PAGE_BYTES
        return names <= {RECIPE, LOG, MANIFEST} and kinds is not None and kinds <= {FILES}

    def _kinds(self) -> set[str] | None:
        """Kinds of entries in the database; None where it is not there, or cannot be read."""
        try:
            with Database(self.folder / DATABASE, read_only=True) as database:
                return set(database.kinds())
        except UserError:
            return None

    def _begin(self, recipe: Mapping[str, Any]) -> None:
        """Write the recipe into a database of its own."""
        for name in PARTS:
            (self.folder / name).unlink(missing_ok=True)
        self._database = Database(self.folder / DATABASE)
        self._write_recipe(recipe)

    def _remove_partial_files(self) -> None:
        for folder in (self.folder, self.folder / "weights", self.folder / "samples"):
            for path in folder.glob(f"*{PARTIAL}"):
                path.unlink()

    def _write_recipe(self, recipe: Mapping[str, Any]) -> None:
        self.write_text(RECIPE, to_yaml(dict(recipe)))


def read_recipe(folder: Path) -> dict[str, Any]:
    """The resolved recipe of the run in a folder.

    Raises `UserError` when it cannot be read, or is not as the run left it.
    """
    path = folder / RECIPE
    text = read_run_file(path, lambda data: data.decode(errors="replace"))
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
