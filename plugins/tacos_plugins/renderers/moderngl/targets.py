"""Framebuffers, pooled by size, and how they are read back."""

from __future__ import annotations

from collections import OrderedDict

import moderngl
import numpy as np
from numpy.typing import NDArray

_KEPT = 8


class Target:
    """What one size of image is rendered into: floats with depth test, one or several samples a pixel.

    Parameters
    ----------
    context
        The context.
    size
        Width and height [px].
    channels
        2 or 4 floats per pixel [1].
    samples
        Samples per pixel; 1 lies at the pixel centre [1].
    """

    def __init__(self, context: moderngl.Context, size: tuple[int, int], channels: int, samples: int):
        self._context = context
        several = samples if samples > 1 else 0
        self.framebuffer = context.framebuffer(
            context.renderbuffer(size, channels, samples=several, dtype="f4"),
            context.depth_renderbuffer(size, samples=several),
        )
        self._resolved = None
        if several:
            self._resolved = context.framebuffer(context.renderbuffer(size, channels, dtype="f4"))

    def read(self, into: NDArray[np.float32]) -> None:
        """Read (H, W, channels) float32 into an array, which may have fewer channels, samples averaged."""
        source = self.framebuffer
        if self._resolved is not None:
            self._context.copy_framebuffer(self._resolved, self.framebuffer)
            source = self._resolved
        source.read_into(into, components=into.shape[2], dtype="f4")

    def release(self) -> None:
        """Give the memory back."""
        for framebuffer in (self.framebuffer, self._resolved):
            if framebuffer is None:
                continue
            for attachment in (*framebuffer.color_attachments, framebuffer.depth_attachment):
                if attachment is not None:
                    attachment.release()
            framebuffer.release()


class TargetPool:
    """Targets by size, channels and samples; the least recently used are released."""

    def __init__(self, context: moderngl.Context):
        self._context = context
        self._targets: OrderedDict[tuple[int, int, int, int], Target] = OrderedDict()

    def get(self, size: tuple[int, int], channels: int, samples: int = 1) -> Target:
        """The target, made on first use."""
        key = (*size, channels, samples)
        if key not in self._targets:
            while len(self._targets) >= _KEPT:
                self._targets.popitem(last=False)[1].release()
            self._targets[key] = Target(self._context, size, channels, samples)
        self._targets.move_to_end(key)
        return self._targets[key]
