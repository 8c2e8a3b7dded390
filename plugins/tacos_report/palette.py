"""Colours of the report: one per camera everywhere, safe for colour-blind readers, light and dark.

Charts are drawn in the light colours; `tinted` swaps each for a CSS variable, so that one drawing serves both
modes.
Camera hues are those of Okabe and Ito, "Color Universal Design" (2008), and a violet, dark enough for words:
4.5 to 1 against paper and cards (WCAG 2.2).
"""

from __future__ import annotations

import re

_CAMERAS = (  # (light, dark); the first is the designed camera's
    ("#b85000", "#ff8b3d"),
    ("#0072b2", "#5ab0e8"),
    ("#007d5b", "#3fcfa4"),
    ("#a94f84", "#e6a3c9"),
    ("#8a6d00", "#f0c948"),
    ("#3d3d3d", "#c4c9d0"),
    ("#6a3fa0", "#b79be0"),
)
_NEUTRALS = {
    "ink": ("#1c2128", "#e8ecf1"),
    "muted": ("#5b6675", "#a3afbe"),
    "rule": ("#d3d9e1", "#39424e"),
    "paper": ("#fdfdfc", "#14181d"),
    "card": ("#f4f5f7", "#1d232b"),
    "dot": ("#64748b", "#a9b8cc"),
}
TERMS = ("#2f4468", "#6f8fbf", "#b3c5de", "#4d6b6a", "#9fbdb6", "#7d7391", "#c9c2d6")
"""Segments of the stacked bars: other hues than any camera's, told apart by lightness."""

INK, MUTED, RULE, PAPER, DOT = (_NEUTRALS[name][0] for name in ("ink", "muted", "rule", "paper", "dot"))


def camera_colour(index: int) -> str:
    """Light-mode colour of the camera at that place, the designed one being 0."""
    return _CAMERAS[_slot(index)][0]


def camera_variable(index: int) -> str:
    """CSS variable of the same colour."""
    return f"var(--camera-{_slot(index)})"


def stylesheet() -> str:
    """CSS that declares every variable, for both modes; print is always light."""
    light = "".join(f"--{name}:{pair[0]};" for name, pair in _tokens().items())
    dark = "".join(f"--{name}:{pair[1]};" for name, pair in _tokens().items())
    return (
        f":root{{color-scheme:light dark;{light}}}\n"
        f"@media screen and (prefers-color-scheme: dark){{:root{{{dark}}}}}\n"
    )


def tinted(svg: str) -> str:
    """The drawing with every colour of the palette replaced by its CSS variable."""
    variables = {pair[0]: f"var(--{name})" for name, pair in _tokens().items()}
    return re.sub(r"#[0-9a-f]{6}\b", lambda match: variables.get(match[0], match[0]), svg)


def _tokens() -> dict[str, tuple[str, str]]:
    return {**_NEUTRALS, **{f"camera-{index}": pair for index, pair in enumerate(_CAMERAS)}}


def _slot(index: int) -> int:
    return index if index < len(_CAMERAS) else 1 + (index - 1) % (len(_CAMERAS) - 1)
