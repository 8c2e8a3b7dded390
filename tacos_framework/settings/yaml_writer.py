"""Writes YAML that `yaml_reader` reads back unchanged."""

from __future__ import annotations

from typing import Any

import yaml

from tacos_framework.settings.yaml_scalars import reads_as_text


class _Dumper(yaml.SafeDumper):
    """Quotes what YAML 1.2 takes for a number; writes out again what stands twice, for want of aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_text(self, text: str) -> yaml.ScalarNode:
        """Text, in quotes where its reader would take it for something else, as ``1e3`` or ``INF``."""
        style = None if reads_as_text(text) else "'"
        return self.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _Dumper.represent_text)


def to_yaml(data: Any, *, flow_style: bool | None = False) -> str:
    """The text of `data`: nested dicts, lists, strings, numbers, truth values and None.

    `data`: what is written; dictionaries keep their order. `flow_style`: None writes the innermost lists and
    dictionaries on one line.

    >>> to_yaml({"name": "1e3", "gain_db": 5.0})
    "name: '1e3'\\ngain_db: 5.0\\n"
    """
    return yaml.dump(
        data, Dumper=_Dumper, sort_keys=False, default_flow_style=flow_style, width=110, allow_unicode=True
    )
