"""Tables of results as data frames of pandas, for those who have it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from tacos_framework.errors import Fault, UserError, did_you_mean

if TYPE_CHECKING:
    import pandas

Row = dict[str, Any]
"""A line of a table: words and numbers by the name of their column."""

Result = TypeVar("Result")


class Tables(Generic[Result]):
    """The named tables of a kind of result.

    - `rows_of`: name of a table -> what makes its rows of a result.
    """

    def __init__(self, rows_of: Mapping[str, Callable[[Result], Iterable[Row]]]) -> None:
        self.rows_of = rows_of

    def rows(self, result: Result, table: str) -> list[Row]:
        """A table as plain values.

        Raises `UserError` when there is no such table.
        """
        if table not in self.rows_of:
            remedy = did_you_mean(table, self.rows_of)
            raise UserError(Fault("table", f"there is no table {table!r}", ", ".join(self.rows_of), remedy))
        return list(self.rows_of[table](result))

    def frame(self, result: Result, table: str) -> pandas.DataFrame:
        """A table as a data frame.

        Raises `UserError` when there is no such table, or pandas is not installed (the extra ``frames``).
        """
        rows = self.rows(result, table)
        try:
            import pandas
        except ImportError as error:
            fault = Fault(
                "pandas",
                "pandas is not installed, which data frames need",
                "the extra frames",
                f"Install it: pip install 'tacos-framework[frames]'; or take plain rows: rows({table!r}).",
            )
            raise UserError(fault) from error
        return pandas.DataFrame(rows)
