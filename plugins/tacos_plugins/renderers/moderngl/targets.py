"""Framebuffers, pooled by size, and how they are read back."""

from __future__ import annotations

from collections import OrderedDict

import moderngl
import numpy as np
from numpy.typing import NDArray

_KEPT = 4


class Targets:
    """What one size of image is rendered into.

    Colour has several samples per pixel, averaged in linear light; truth has one, at the pixel centre.

    Parameters
    ----------
    context
        The context.
    size
        Width and height [px].
    samples
        Samples per pixel of the colour target [1].
    """

    def __init__(self, context: moderngl.Context, size: tuple[int, int], samples: int):
        self._context = context
        self.size = size
        self.colour = context.framebuffer(
            context.renderbuffer(size, 4, samples=samples, dtype="f4"),
            context.depth_renderbuffer(size, samples=samples),
        )
        self._resolved = context.framebuffer(context.renderbuffer(size, 4, dtype="f4"))
        self.truth = context.framebuffer(
            context.renderbuffer(size, 2, dtype="f4"), context.depth_renderbuffer(size)
        )

    def read_colour(self, into: NDArray[np.float32]) -> None:
        """Average the samples and read (H, W, 3) float32 luminance [cd/m2]."""
        self._context.copy_framebuffer(self._resolved, self.colour)
        self._resolved.read_into(into, components=3, dtype="f4")

    def read_truth(self, into: NDArray[np.float32]) -> None:
        """Read (H, W, 2) float32: depth [m] and object id."""
        self.truth.read_into(into, components=2, dtype="f4")

    def release(self) -> None:
        """Give the memory back."""
        for framebuffer in (self.colour, self._resolved, self.truth):
            for attachment in (*framebuffer.color_attachments, framebuffer.depth_attachment):
                if attachment is not None:
                    attachment.release()
            framebuffer.release()


class TargetPool:
    """Targets by size; the least recently used are released."""

    def __init__(self, context: moderngl.Context):
        self._context = context
        self._targets: OrderedDict[tuple[int, int, int], Targets] = OrderedDict()

    def get(self, size: tuple[int, int], samples: int) -> Targets:
        """The targets of a size, made on first use."""
        key = (*size, samples)
        if key not in self._targets:
            while len(self._targets) >= _KEPT:
                self._targets.popitem(last=False)[1].release()
            self._targets[key] = Targets(self._context, size, samples)
        self._targets.move_to_end(key)
        return self._targets[key]
