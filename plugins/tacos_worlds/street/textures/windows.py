"""Windows of a front, no two alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tacos_worlds.street.textures.walls import Canvas, Colour


@dataclass(frozen=True)
class WindowStyle:
    """Look of the windows of a front; lengths in cells of the wall."""

    width: float  # of the opening [cell]
    height: float  # of the opening [cell]
    sill: float  # above the floor [cell]
    columns: int
    rows: int
    trim: float  # width of the surround; 0 for none [cell]
    frame: Colour  # colour of the frames


def draw_window_style(rng: np.random.Generator, wall: str) -> WindowStyle:
    wide = wall == "concrete"
    return WindowStyle(
        width=float(rng.uniform(0.6, 0.86) if wide else rng.uniform(0.32, 0.46)),
        height=float(rng.uniform(0.45, 0.56)),
        sill=float(rng.uniform(0.26, 0.32)),
        columns=int(rng.integers(2, 5)) if wide else 2,
        rows=int(rng.integers(1, 4)),
        trim=0.0 if wide else float(rng.choice([0.0, 0.035, 0.05])),
        frame=((0.93, 0.93, 0.91), (0.9, 0.9, 0.9), (0.25, 0.26, 0.28), (0.36, 0.27, 0.2))[
            int(rng.integers(4))
        ],
    )


def glass(rng: np.random.Generator, canvas: Canvas, u: tuple[float, float], v: tuple[float, float]) -> None:
    """Panes that mirror some sky, with what hangs or stands behind them."""
    rows, columns = canvas.rectangle(u, v)
    height, width = rows.stop - rows.start, columns.stop - columns.start
    sky = rng.uniform(0.05, 0.38) * np.linspace(0, 1, height)[:, None, None] * np.array([0.75, 0.9, 1.0])
    pane = np.broadcast_to(np.array([0.16, 0.19, 0.22]) + sky, (height, width, 3)).copy()
    kind = rng.uniform()
    if kind < 0.3:  # curtains to both sides
        cloth = np.array([0.86, 0.83, 0.76]) * rng.uniform(0.55, 0.95)
        folds = 1 + 0.12 * np.sin(np.arange(width) / max(width, 1) * rng.uniform(40, 70))[None, :, None]
        share = int(width * rng.uniform(0.15, 0.38))
        for side in (slice(0, share), slice(width - share, width)):
            pane[:, side] = cloth * np.broadcast_to(folds, pane.shape)[:, side]
    elif kind < 0.5:  # a blind
        drop = int(height * rng.uniform(0.2, 0.8))
        slats = 1 + 0.1 * np.sin(np.arange(height) * 1.6)[:, None, None]
        pane[height - drop :] = (np.array([0.85, 0.84, 0.8]) * rng.uniform(0.6, 0.95) * slats)[
            height - drop :
        ]
    elif kind < 0.6:  # a lamp is on
        pane[:] = 0.5 * pane + 0.5 * np.array([0.8, 0.68, 0.45])
    canvas.colour[rows, columns] = pane
    canvas.height_m[rows, columns] = -0.12


def window(rng: np.random.Generator, canvas: Canvas, style: WindowStyle, bay: int, floor: int) -> None:
    middle = bay + 0.5
    u = (middle - style.width / 2, middle + style.width / 2)
    v = (floor + style.sill, floor + style.sill + style.height)
    if style.trim:
        t = style.trim
        canvas.fill((u[0] - t, u[1] + t), (v[0] - t, v[1] + t), (0.90, 0.88, 0.83), 0.03)
        canvas.shade((u[0] - t, u[1] + t), (v[0] - t - 0.012, v[0] - t), 0.6)
    frame = 0.022
    canvas.fill(u, v, style.frame, -0.08)
    step_u = (u[1] - u[0] - frame) / style.columns
    step_v = (v[1] - v[0] - frame) / style.rows
    for column in range(style.columns):
        for row in range(style.rows):
            left, low = u[0] + frame + column * step_u, v[0] + frame + row * step_v
            glass(rng, canvas, (left, left + step_u - frame), (low, low + step_v - frame))
    canvas.shade(u, (v[1] - 0.035, v[1]), 0.45)  # the lintel's shadow
    canvas.fill((u[0] - 0.03, u[1] + 0.03), (v[0] - 0.03, v[0]), (0.78, 0.77, 0.74), 0.06)
    canvas.shade((u[0] - 0.02, u[1] + 0.02), (v[0] - 0.05, v[0] - 0.03), 0.55)
