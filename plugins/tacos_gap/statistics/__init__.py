"""Statistics that images are compared by, family by family.

A family is a function from a `Sample` to blocks of numbers. Adding one to `FAMILIES` is all it takes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tacos_gap.statistics.blemishes import blemish_statistics
from tacos_gap.statistics.block import Sample, StatisticBlock
from tacos_gap.statistics.codes import code_statistics
from tacos_gap.statistics.colour import colour_statistics
from tacos_gap.statistics.compression import compression_statistics
from tacos_gap.statistics.displacement import displacement_statistics
from tacos_gap.statistics.field import field_statistics
from tacos_gap.statistics.fixed_pattern import fixed_pattern_statistics
from tacos_gap.statistics.hot_pixels import hot_pixel_statistics
from tacos_gap.statistics.levels import level_statistics
from tacos_gap.statistics.lines import line_statistics
from tacos_gap.statistics.noise import noise_statistics
from tacos_gap.statistics.rows import row_statistics
from tacos_gap.statistics.sharpness import sharpness_statistics

Family = Callable[[Sample], Iterator[StatisticBlock]]

FAMILIES: tuple[Family, ...] = (
    level_statistics,
    field_statistics,
    noise_statistics,
    fixed_pattern_statistics,
    blemish_statistics,
    hot_pixel_statistics,
    row_statistics,
    line_statistics,
    code_statistics,
    sharpness_statistics,
    displacement_statistics,
    colour_statistics,
    compression_statistics,
)

__all__ = ["FAMILIES", "Family", "Sample", "StatisticBlock", "measure"]


def measure(sample: Sample) -> list[StatisticBlock]:
    return [block for family in FAMILIES for block in family(sample)]
