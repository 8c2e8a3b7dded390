"""A self-contained page of a procedure: text, drawings, pictures and tables in the report's style."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from jinja2 import Environment


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of plain text."""

    text: str
    kind: Literal["paragraph"] = "paragraph"


@dataclass(frozen=True)
class Warnings:
    """Sentences a reader must not miss; nothing where there are none."""

    title: str
    sentences: tuple[str, ...]
    kind: Literal["warnings"] = "warnings"


@dataclass(frozen=True)
class Drawing:
    """An inline SVG, as `tacos_report.figures.canvas.draw` gives it; ``narrow`` is the same for a phone."""

    svg: str
    caption: str
    narrow: str = ""
    kind: Literal["drawing"] = "drawing"


def in_both_widths(drawn: Callable[..., str], caption: str = "") -> Drawing:
    """A drawing as ``drawn(narrow=False)`` gives it, and ``drawn(narrow=True)`` for the width of a phone."""
    return Drawing(drawn(narrow=False), caption, narrow=drawn(narrow=True))


@dataclass(frozen=True)
class PagePicture:
    """An image as a data URI, as `image_uri` gives it; `enlarged` fills the width with pixels left sharp."""

    uri: str
    caption: str
    enlarged: bool = False
    kind: Literal["picture"] = "picture"


@dataclass(frozen=True)
class Detailed:
    """A cell with a detail in small print below its text."""

    text: str
    detail: str


@dataclass(frozen=True)
class Table:
    """Rows of text under a heading."""

    heads: tuple[str, ...]
    rows: tuple[tuple[str | Detailed, ...], ...]
    caption: str = ""
    kind: Literal["table"] = "table"


@dataclass(frozen=True)
class Code:
    """Text to be copied: a command, a file."""

    text: str
    kind: Literal["code"] = "code"


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    text: str
    kind: Literal["heading"] = "heading"


@dataclass(frozen=True)
class SideBySide:
    """Blocks side by side, all equally wide."""

    blocks: tuple[Drawing | PagePicture | Table, ...]
    kind: Literal["row"] = "row"


@dataclass(frozen=True)
class ContactSheet:
    """Small pictures in as many columns as there is room for."""

    pictures: tuple[PagePicture, ...]
    kind: Literal["contact-sheet"] = "contact-sheet"


@dataclass(frozen=True)
class Folded:
    """A table that opens when its summary is clicked: for rows that few want to see."""

    summary: str
    table: Table
    kind: Literal["folded"] = "folded"


Block = (
    Paragraph | Warnings | Drawing | PagePicture | Table | Code | Heading | SideBySide | ContactSheet | Folded
)


@dataclass(frozen=True)
class Section:
    """A part of a page."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Page:
    """A page.

    Parameters
    ----------
    eyebrow
        What kind of page it is, in small letters above the title.
    title
        The finding, in a sentence.
    lead
        What stands behind it, in a paragraph.
    reload_s
        Seconds after which the page loads itself anew; None for one that stays as it is.
    """

    eyebrow: str
    title: str
    lead: str
    sections: Sequence[Section]
    reload_s: float | None = None


def image_uri(image: NDArray[np.uint8]) -> str:
    """An (H, W) or (H, W, 3) RGB image as a PNG in a data URI."""
    import cv2

    ordered = image if image.ndim == 2 else image[..., ::-1]
    _, data = cv2.imencode(".png", np.ascontiguousarray(ordered))
    return f"data:image/png;base64,{base64.b64encode(data.tobytes()).decode()}"


CONTENT_POLICY = (
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
)
"""What a browser may do with a page: show it, with pictures inside of it. No script runs, nothing is fetched.

Styles stand beside what they are of, which no hash can name; what a result holds is escaped all the same.
"""


def write_page(path: Path, page: Page) -> None:
    """Write the page as one HTML file that fetches nothing."""
    from markupsafe import Markup

    from tacos_report.palette import stylesheet

    template = page_templates().get_template("page.html.j2")
    write_html(path, template.render(page=page, palette=Markup(stylesheet())))


def page_templates() -> Environment:
    """Where the templates of all pages are found, ``page.css`` for one; text is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=PackageLoader("tacos_report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["svg"] = Markup
    environment.globals["policy"] = CONTENT_POLICY
    return environment


def write_html(path: Path, text: str) -> Path:
    """Write a page whole or not at all: a reader never meets half of it."""
    partial = path.with_name(f"{path.name}.partial")
    partial.write_text(text, encoding="utf-8")
    partial.replace(path)
    return path
