"""A running study in the terminal."""

from __future__ import annotations

from rich.console import Group
from rich.table import Table
from rich.text import Text

from tacos_report.watching.in_words import HEADS, ranking, state
from tacos_report.watching.running_study import RunningStudy


def screen(study: RunningStudy, now_s: float) -> Group:
    """Name, state, ranking and the last line of the log; nothing in them is taken for markup."""
    table = Table(box=None, pad_edge=False)
    for head in HEADS:
        table.add_column(head, justify="right" if head == "Fitness" else "left")
    for row in ranking(study):
        table.add_row(*map(Text, row))
    return Group(
        Text(study.name, style="bold"),
        Text(state(study, now_s)),
        table,
        Text(f"{study.last_line}\n", style="dim"),
    )
