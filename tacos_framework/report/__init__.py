"""The HTML report of a study: one file, pictures first, nothing fetched from elsewhere.

Importing this package loads neither matplotlib nor jinja2; `write_report` does.
"""

from __future__ import annotations

from pathlib import Path

__all__ = ["write_report"]


def write_report(folder: Path) -> Path:
    """Read a results folder and write ``report.html`` into it.

    Parameters
    ----------
    folder
        A folder a study has written; it needs at least ``result.json``.

    Returns
    -------
    Path
        The report, one self-contained file.

    Raises
    ------
    UserError
        Where the folder holds no readable ``result.json``.
    """
    from tacos_framework.report.html import render
    from tacos_framework.report.study_data import read_study

    path = folder / "report.html"
    partial = folder / "report.html.partial"
    partial.write_text(render(read_study(folder)), encoding="utf-8")
    partial.replace(path)  # a reader never meets half a report
    return path
