"""Studies of a comparison, and the table they are put into."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pydantic import JsonValue, model_validator

from tacos_framework import Settings, did_you_mean, setting
from tacos_framework.store import DESIGNED


class StudyChange(Settings):
    """One of the studies: the problem with some keys changed."""

    change: dict[str, JsonValue] = setting(
        {}, help="Keys of the problem's recipe to change, as with --set, over those of all studies."
    )
    problem: str | None = setting(
        None, help="Another recipe than that of all studies: a path, or the name of a shipped one."
    )


class SummaryColumn(Settings):
    head: str = setting(help="Its heading.", min_length=1)
    value: str = setting(
        help="Its value: camera.VARIABLE, derived.QUANTITY, or test.SCORE, e.g. test.stereo.log_error.",
        pattern=r"^(camera|derived|test)\..+$",
    )
    unit: str = setting("", help="Its unit.")
    better: Literal["lower", "higher"] | None = setting(
        None, help="Which figures are better, for the best one to be marked; neither for parameters."
    )
    digits: int = setting(3, help="Digits shown.", ge=1, le=9)


class TableRow(Settings):
    """A row of the table: a camera of one of the studies."""

    title: str = setting(help="Its name.", min_length=1)
    study: str = setting(help="Which of the studies it comes from.")
    camera: str = setting(DESIGNED, help="The designed camera, or one the study compares it with.")
    published: dict[str, float | str] = setting({}, help="Published figures, by the heads of columns.")


class StudiesConfig(Settings):
    problem: str = setting(
        help="The recipe of the studies: a path, or the name of a shipped one.", is_path=True
    )
    change: dict[str, JsonValue] = setting({}, help="Keys of that recipe to change in all studies.")
    studies: dict[str, StudyChange] = setting(help="The studies by name.", min_length=1)
    optional: tuple[str, ...] = setting(
        (), help="Studies to leave out, with a note, where the packages they need are not installed."
    )
    seeds: int = setting(1, help="Runs of each study, with the seed of the problem and those after it.", ge=1)
    columns: tuple[SummaryColumn, ...] = setting(help="The columns of the table.", min_length=1)
    rows: tuple[TableRow, ...] = setting(help="The rows of the table.", min_length=1)
    published_in: str = setting("", help="Place of the published figures, e.g. the paper, Table 1.")
    differs: tuple[str, ...] = setting(
        (), help="Reasons why these figures do not compare with the published ones, in sentences."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> StudiesConfig:
        if wrong := list(self._misfits()):
            raise ValueError("; ".join(wrong))
        return self

    def _misfits(self) -> Iterator[str]:
        heads = [column.head for column in self.columns]
        for name in self.studies:
            if not name.replace("_", "").replace("-", "").isalnum():
                yield f"the name of a study is part of a folder's, so not {name!r}"
        for name in self.optional:
            if name not in self.studies:
                yield f"optional names no study {name!r}. {did_you_mean(name, self.studies)}".rstrip()
        for number, row in enumerate(self.rows):
            if row.study not in self.studies:
                hint = did_you_mean(row.study, self.studies)
                yield f"rows.{number} names no study {row.study!r}. {hint}".rstrip()
            for head in row.published:
                if head not in heads:
                    hint = did_you_mean(head, heads)
                    yield f"rows.{number}.published names no column {head!r}. {hint}".rstrip()
        if len(set(heads)) != len(heads):
            yield f"columns need different heads, not {', '.join(heads)}"
