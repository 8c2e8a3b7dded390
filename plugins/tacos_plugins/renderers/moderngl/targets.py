"""Framebuffers, pooled by size, and how they are read back."""

from __future__ import annotations

from collections import OrderedDict

import moderngl
import numpy as np
from numpy.typing import NDArray

_SIZES_KEPT = 8


class RenderTarget:
    """What one size of image is rendered into: floats with depth test, one or several samples a pixel.

    Parameters
    ----------
    context
        The context.
    size
        Width and height [px].
    channels
        1, 2 or 4 floats per pixel [1].
    samples
        Samples per pixel; 1 lies at the pixel centre [1].
    depth
        A depth buffer of that size to draw over, of which another target is the owner.
    """

    def __init__(
        self,
        context: moderngl.Context,
        size: tuple[int, int],
        channels: int,
        samples: int,
        depth: moderngl.Renderbuffer | None = None,
    ):
        self._context, self._owns_depth = context, depth is None
        several = samples if samples > 1 else 0
        self.depth = depth or context.depth_renderbuffer(size, samples=several)
        self.framebuffer = context.framebuffer(
            context.renderbuffer(size, channels, samples=several, dtype="f4"),
            self.depth,
        )
        self.framebuffer.depth_mask = self._owns_depth
        self._resolved = None
        if several:
            self._resolved = context.framebuffer(context.renderbuffer(size, channels, dtype="f4"))

    def read(self, into: NDArray[np.float32]) -> None:
        """Read (H, W, channels) float32 into an array, which may have fewer channels, samples averaged."""
        self._source().read_into(into, components=into.shape[2], dtype="f4")

    def copy(self, into: moderngl.Buffer, channels: int) -> None:
        """Begin to copy (H, W, channels) float32 into a buffer of the device, samples averaged."""
        self._source().read_into(into, components=channels, dtype="f4")

    def _source(self) -> moderngl.Framebuffer:
        if self._resolved is None:
            return self.framebuffer
        self._context.copy_framebuffer(self._resolved, self.framebuffer)
        return self._resolved

    def release(self) -> None:
        """Give the memory back."""
        for framebuffer in (self.framebuffer, self._resolved):
            if framebuffer is None:
                continue
            for attachment in framebuffer.color_attachments:
                attachment.release()
            framebuffer.release()
        if self._owns_depth:
            self.depth.release()


class TargetPool:
    """Targets by size; all of the sizes least recently used are released."""

    def __init__(self, context: moderngl.Context):
        self._context = context
        self._targets: OrderedDict[tuple[int, int], dict[tuple[int, int, int], RenderTarget]] = OrderedDict()

    def get(
        self, size: tuple[int, int], channels: int, samples: int = 1, depth_of: int | None = None
    ) -> RenderTarget:
        """The target, made on first use.

        Parameters
        ----------
        depth_of
            Channels of the target of the same size whose depth is tested against and kept.
        """
        if size not in self._targets:
            while len(self._targets) >= _SIZES_KEPT:
                for target in self._targets.popitem(last=False)[1].values():
                    target.release()
            self._targets[size] = {}
        self._targets.move_to_end(size)
        of_size = self._targets[size]
        key = (channels, samples, depth_of or 0)
        if key not in of_size:
            depth = None if depth_of is None else self.get(size, depth_of, samples).depth
            of_size[key] = RenderTarget(self._context, size, channels, samples, depth)
        return of_size[key]
