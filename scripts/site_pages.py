"""What `make docs` adds to the pages of ``docs``: the navigation, pages of the API and of settings.

A hook of MkDocs (``mkdocs.yml``). The navigation is that of ``docs/index.md``; the API is what the packages
`tacos_framework`, `tacos_framework.testing` and `tacos` export, so that nothing is listed twice.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from tacos_plugins.authoring.reference.pages import pages_of_the_site

ROOT = Path(__file__).resolve().parents[1]

SUBJECTS = {
    "Run and embed": (
        "runner",
        "recipe",
        "simulation",
        "study",
        "fitness",
        "quantities",
        "cli",
        "environment",
        "data_frames",
    ),
    "Contracts": ("contracts", "hookspecs", "graph", "randomness", "cache", "linear_algebra"),
    "Values": ("values",),
    "Settings and variables": ("settings", "variables"),
    "Catalogs and plugins": ("catalog", "components", "plugins", "packaged_resources", "errors"),
}
"""Title of a page -> the modules of the core whose public names it shows."""

_CODE = re.compile(r"(?<=<code>)[^<\n]+(?=</code>)")
_JOINT = re.compile(r"(?<=[_./])(?=\w)")
_LINK = re.compile(r"\[(?P<title>[^]]+)\]\((?P<page>[^)#:]+\.md)\)")


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Take the navigation from the index: a tab for each heading, a page for each of its links."""
    sections = list(navigation(Path(config.docs_dir, "index.md").read_text("utf-8")))
    look_up = next(section["Look up"] for section in sections if "Look up" in section)
    look_up += [{title: page_of(title, "reference")} for title in pages_of_the_site()]
    api = {"API": [{title: page_of(title)} for title in api_pages()]}
    config.nav = [{"Home": "index.md"}, *sections, api]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages of the API, and those of the reference that the repository leaves to the site."""
    for title, text in api_pages().items():
        files.append(File.generated(config, page_of(title), content=text))
    for title, write in pages_of_the_site().items():
        files.append(File.generated(config, page_of(title, "reference"), content=write()))
    return files


def on_page_content(html: str, **_: Any) -> str:
    """Let names break behind ``_``, ``.`` and ``/``, so that they fit a phone."""
    return _CODE.sub(lambda name: _JOINT.sub("<wbr>", name[0]), html)


def navigation(index: str) -> Iterator[dict[str, Any]]:
    """The sections of the index with the pages they link to."""
    for section in index.split("\n## ")[1:]:
        heading, _, text = section.partition("\n")
        yield {heading: [{found["title"]: found["page"]} for found in _LINK.finditer(text)]}


def page_of(title: str, folder: str = "api") -> str:
    """Where a generated page lies in the site."""
    return f"{folder}/{title.lower().replace(' ', '_')}.md"


def api_pages() -> dict[str, str]:
    """The text of each page of the API, by its title."""
    names: dict[str, list[str]] = {title: [] for title in SUBJECTS}
    title_of = {module: title for title, modules in SUBJECTS.items() for module in modules}
    for module, name in public_names():
        names[title_of[module]].append(name)
    pages = {"tacos": _page("tacos", "\n".join(_described_once(name) for name in names_for_users()))}
    for title, shown in names.items():
        pages[title] = _page(title, "\n".join(f"::: tacos_framework.{name}\n" for name in sorted(shown)))
    pages["Testing"] = _page("Testing", "::: tacos_framework.testing\n    options: {members: true}\n")
    return pages


def public_names() -> Iterator[tuple[str, str]]:
    """The module of the core, directly below its root, and the name, of all that the core exports.

    Raises
    ------
    KeyError
        In `api_pages`, when a module has no page in `SUBJECTS`.
    """
    stub = ast.parse((ROOT / "tacos_framework" / "__init__.pyi").read_text("utf-8"))
    for statement in stub.body:
        if isinstance(statement, ast.ImportFrom) and statement.module:
            for alias in statement.names:
                yield statement.module.partition(".")[0], alias.name


def names_for_users() -> Iterator[str]:
    """Where the names of `tacos` are defined, as type checkers see them."""
    module = ast.parse((ROOT / "plugins" / "tacos" / "__init__.py").read_text("utf-8"))
    for statement in ast.walk(module):
        if isinstance(statement, ast.ImportFrom) and (statement.module or "").startswith("tacos"):
            names = (alias.name for alias in statement.names)
            yield from (f"{statement.module}.{name}" for name in names if not name.startswith("__"))


def _described_once(name: str) -> str:
    """The description of a name; a link where a page of the core has it."""
    in_core = name.startswith("tacos_framework.")
    return f"- `tacos`.[{name.rpartition('.')[2]}][{name}]" if in_core else f"\n::: {name}\n"


def _page(title: str, body: str) -> str:
    return f"# {title}\n\n{body}"
