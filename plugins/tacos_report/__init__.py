"""Pages of procedures, and the report of a study: one file each, nothing fetched from elsewhere.

================  ===========================================================================================
``page``          the one model of all pages: sections of text, tables, drawings, written in one go
``palette``       the colours of all of them, in light and dark
``quantities``    numbers in words
``study_data``    a results folder as plain values
``story``         sentences made from them, with ``comparison`` behind the differences
``pictures``      sample frames, and how large to show them beside one another
``view_geometry`` where a camera looks: pure geometry
``figures``       the drawings, one a file, on the ``canvas`` that all pages draw on
``study_page``    the report of a study, from the ``sections`` that each show one thing
``watching``      a study while it runs, in the terminal or as a page that reloads itself
================  ===========================================================================================

Importing this package loads neither matplotlib nor jinja2; `write_report` does.
"""

from __future__ import annotations

from pathlib import Path

__all__ = ["write_report"]


def write_report(folder: Path) -> Path:
    """Read the results folder of a study and write ``report.html`` into it.

    `folder`: a folder a study has written; it needs at least ``result.json``.

    Returns: the report, one self-contained file.

    Raises `UserError` where the folder holds no readable ``result.json``.
    """
    from tacos_report.page import write_page
    from tacos_report.study_data import read_study
    from tacos_report.study_page import study_page

    report = folder / "report.html"
    write_page(report, study_page(read_study(folder)))
    return report
