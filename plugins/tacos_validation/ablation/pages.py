"""The report of an ablation: what each step changes, in one table."""

from __future__ import annotations

from collections.abc import Sequence

from tacos_report.page import Page, Section, Table, Warnings
from tacos_validation.ablation.order import Order
from tacos_validation.ablation.settings import AblationConfig
from tacos_validation.harness import csv_text

HEADS = ("Study", "Tau", "Best", "Equal to it", "Largest change of place")


def page(config: AblationConfig, orders: Sequence[Order], left_out: Sequence[str], scenes: int) -> Page:
    cameras = tuple(orders[0].fitness)
    rows = tuple(
        (name, *(f"{order.fitness[name]:.3f}" for order in orders))
        for name in sorted(cameras, key=lambda name: -orders[0].fitness[name])
    )
    missing = tuple(f"{name} has no place in some variant and is left out of all." for name in left_out)
    return Page(
        eyebrow="Ablation",
        title=summary(orders).splitlines()[0],
        lead=(
            f"{len(cameras)} cameras on the same {scenes} scenes, ranked by {config.study} as it stands and "
            f"with steps left out. Tau is Kendall's tau-b with the study as it stands, in brackets its "
            f"{config.confidence:.0%} interval over draws of scenes."
        ),
        sections=(
            Section("What each step changes", (Table(HEADS, tuple(map(_row, orders))),)),
            *((Section("Notes", (Warnings("What to know", missing),)),) if missing else ()),
            Section("Fitness", (Table(("Camera", *(order.variant for order in orders)), rows),)),
        ),
    )


def summary(orders: Sequence[Order]) -> str:
    most = min(orders[1:], key=lambda order: 2.0 if order.agreement.tau is None else order.agreement.tau)
    lines = [f"The ranking changes most {most.variant}: tau {_tau(most)}"]
    return "\n".join([*lines, *(": ".join((row[0], ", ".join(row[1:]))) for row in map(_row, orders))])


def table_csv(orders: Sequence[Order]) -> str:
    return csv_text(HEADS, map(_row, orders))


def _row(order: Order) -> tuple[str, ...]:
    moved = f"{order.moved_camera} by {order.moved:g}" if order.moved else "none"
    return order.variant, _tau(order), order.best, f"{len(order.equal)} of {len(order.fitness)}", moved


def _tau(order: Order) -> str:
    found = order.agreement
    if found.tau is None:
        return "not defined"
    return f"{found.tau:.2f}" + (
        f" [{found.interval[0]:.2f}, {found.interval[1]:.2f}]" if found.interval else ""
    )
