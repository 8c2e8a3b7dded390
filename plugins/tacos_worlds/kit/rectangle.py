"""Rectangles along the axes, as rooms, lots and tops of tables are laid out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Rect:
    """A rectangle along the axes, from (x0, y0) to (x1, y1) [m]."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [m]."""
        return self.x1 - self.x0, self.y1 - self.y0

    @property
    def centre(self) -> tuple[float, float]:
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    def grown(self, by_m: float) -> Rect:
        """The rectangle with every edge moved outwards, or inwards where negative [m]."""
        return Rect(self.x0 - by_m, self.y0 - by_m, self.x1 + by_m, self.y1 + by_m)

    def overlaps(self, other: Rect, gap_m: float = 0.0) -> bool:
        """True if the two come closer than `gap_m` [m]."""
        return (
            self.x0 < other.x1 + gap_m
            and other.x0 < self.x1 + gap_m
            and self.y0 < other.y1 + gap_m
            and other.y0 < self.y1 + gap_m
        )

    def contains(self, other: Rect) -> bool:
        return self.x0 <= other.x0 and self.y0 <= other.y0 and other.x1 <= self.x1 and other.y1 <= self.y1
