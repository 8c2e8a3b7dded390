"""A self-contained page of a procedure: text, drawings, pictures and tables in the report's style."""

from __future__ import annotations

import base64
import hashlib
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
    """A paragraph of plain text; a quiet one explains what stands beside it."""

    text: str
    quiet: bool = False
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
    widest_px: int | None = None
    kind: Literal["picture"] = "picture"


@dataclass(frozen=True)
class Detailed:
    """A cell with a detail in small print below its text; the best of a row is named."""

    text: str
    detail: str = ""
    best: bool = False
    anchor: str = ""  # of the `Folded` that its text leads to and opens


@dataclass(frozen=True)
class Table:
    """Rows of text under a heading."""

    heads: tuple[str, ...]
    rows: tuple[tuple[str | Detailed, ...], ...]
    caption: str = ""
    colours: tuple[str, ...] = ()  # a CSS colour per head, "" for none
    row_heads: bool = False  # true if the first cell of each row is its heading
    total: bool = False  # true if the last row sums up the others
    first: int = 0
    """How many rows are shown until all are asked for, where the reader's program can ask; 0 for all."""
    kept: tuple[int, ...] = ()  # places of further rows that are shown from the first
    kind: Literal["table"] = "table"


@dataclass(frozen=True)
class Code:
    """Text to be copied: a command, a file."""

    text: str
    kind: Literal["code"] = "code"


@dataclass(frozen=True)
class Heading:
    text: str
    kind: Literal["heading"] = "heading"


@dataclass(frozen=True)
class SideBySide:
    """Blocks side by side, all equally wide."""

    blocks: tuple[Drawing | PagePicture | Table | Paragraph, ...]
    kind: Literal["row"] = "row"


@dataclass(frozen=True)
class ContactSheet:
    """Small pictures in as many columns as there is room for."""

    pictures: tuple[PagePicture, ...]
    kind: Literal["contact-sheet"] = "contact-sheet"


@dataclass(frozen=True)
class Folded:
    """Blocks that open when their summary is clicked, or a link to their anchor: for what few want to see."""

    summary: str
    blocks: tuple[Block, ...]
    anchor: str = ""
    kind: Literal["folded"] = "folded"


@dataclass(frozen=True)
class Legend:
    """Meaning of colours, as (name, CSS colour)."""

    entries: tuple[tuple[str, str], ...]
    kind: Literal["legend"] = "legend"


@dataclass(frozen=True)
class Hero:
    """The first picture of a page beside its facts: (label, value, detail), the main one first."""

    facts: tuple[tuple[str, str, str], ...]
    picture: Drawing | PagePicture | None = None
    widest_px: int | None = None
    kind: Literal["hero"] = "hero"


@dataclass(frozen=True)
class Frame:
    """A picture of a `FrameRow`: where it lies in percent of the row's width, and what it is."""

    uri: str
    alt: str
    title: str
    detail: str
    colour: str
    width: float
    top: float


@dataclass(frozen=True)
class FrameRow:
    """Pictures of one moment side by side, to one scale, at most so wide."""

    frames: tuple[Frame, ...]
    widest_px: int
    kind: Literal["frames"] = "frames"


Block = (
    Paragraph
    | Warnings
    | Drawing
    | PagePicture
    | Table
    | Code
    | Heading
    | SideBySide
    | ContactSheet
    | Folded
    | Legend
    | Hero
    | FrameRow
)


@dataclass(frozen=True)
class Section:
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Page:
    """A page."""

    eyebrow: str  # what kind of page it is, in small letters above the title
    title: str  # the finding, in a sentence
    lead: str  # what stands behind it, in a paragraph
    sections: Sequence[Section]
    reload_s: float | None = None
    """Seconds after which the page loads itself anew; None for one that stays as it is."""
    header: tuple[Block, ...] = ()  # what stands below the lead, before the first section
    tab_title: str = ""  # what a browser shows on its tab; the eyebrow by default
    version: str = ""  # version of the package that made what is shown, where it is known


def image_uri(image: NDArray[np.uint8]) -> str:
    """An (H, W) or (H, W, 3) RGB image as a PNG in a data URI."""
    import cv2

    ordered = image if image.ndim == 2 else image[..., ::-1]
    _, data = cv2.imencode(".png", np.ascontiguousarray(ordered))
    return f"data:image/png;base64,{base64.b64encode(data.tobytes()).decode()}"


CONTENT_POLICY = (
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; "
    "script-src 'sha256-{}'"
)
"""What a browser may do with a page: show it, with pictures inside of it, and run the page's own script.

The script sorts and filters tables, and is named by its hash: no other runs, and nothing is fetched. Styles
stand beside what they are of, which no hash can name; what a result holds is escaped all the same.
"""


def write_page(path: Path, page: Page) -> None:
    """Write the page as one HTML file that fetches nothing, whole or not at all."""
    partial = path.with_name(f"{path.name}.partial")
    partial.write_text(html_of(page), encoding="utf-8")
    partial.replace(path)


def html_of(page: Page) -> str:
    """The page as HTML; all text is escaped."""
    from markupsafe import Markup

    from tacos_report.palette import stylesheet

    template = _templates().get_template("page.html.j2")
    return template.render(page=page, palette=Markup(stylesheet()))


def _templates() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    loader = PackageLoader("tacos_report")
    environment = Environment(
        loader=loader,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["svg"] = Markup
    script, *_ = loader.get_source(environment, "tables.js")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    environment.globals["policy"] = CONTENT_POLICY.format(digest)
    environment.globals["script"] = Markup(script)
    return environment
