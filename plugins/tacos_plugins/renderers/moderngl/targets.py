"""Framebuffers, pooled by size, and the memory they are read back into."""

from __future__ import annotations

import math
from collections import OrderedDict

import moderngl
import numpy as np
from numpy.typing import NDArray

from tacos_plugins.renderers.software.lanes import with_lanes

_MOST_BYTES = 1 << 30
_MOST_SIZES = 8
_MOST_BUFFERS = 8  # those of two cameras


class RenderTarget:
    """Framebuffer of one size of image: floats with depth test, one or several samples a pixel.

    - `size`: width and height [px].
    - `channels`: 1, 2 or 4 floats per pixel [1].
    - `samples`: samples per pixel; 1 lies at the pixel centre [1].
    - `fills_depth`: whether depth can be filled in before something is drawn.
    """

    def __init__(
        self,
        context: moderngl.Context,
        size: tuple[int, int],
        channels: int,
        samples: int,
        fills_depth: bool = False,
    ):
        self._context = context
        self.nbytes = 4 * size[0] * size[1] * samples * (channels + 1)
        several = samples if samples > 1 else 0
        self._filled = context.depth_texture(size) if fills_depth else None
        self.framebuffer = context.framebuffer(
            context.renderbuffer(size, channels, samples=several, dtype="f4"),
            self._filled or context.depth_renderbuffer(size, samples=several),
        )
        self._resolved = None
        if several:
            self._resolved = context.framebuffer(context.renderbuffer(size, channels, dtype="f4"))

    def read(self, into: NDArray[np.float32]) -> None:
        """Read (H, W, channels) float32 into an array, which may have fewer channels, samples averaged."""
        self._source().read_into(into, components=into.shape[2], dtype="f4")

    def copy(self, into: moderngl.Buffer, channels: int) -> None:
        """Begin to copy (H, W, channels) float32 into a buffer of the device, samples averaged."""
        self._source().read_into(into, components=channels, dtype="f4")

    def fill_depth(self, depth: NDArray[np.float32]) -> None:
        """Set (H, W) window depths [1]."""
        assert self._filled is not None
        self._filled.write(depth)

    def _source(self) -> moderngl.Framebuffer:
        if self._resolved is None:
            return self.framebuffer
        self._context.copy_framebuffer(self._resolved, self.framebuffer)
        return self._resolved

    def release(self) -> None:
        for framebuffer in (self.framebuffer, self._resolved):
            if framebuffer is None:
                continue
            for attachment in (*framebuffer.color_attachments, framebuffer.depth_attachment):
                if attachment is not None:
                    attachment.release()
            framebuffer.release()


class TargetPool:
    """Targets by size; all of the sizes least recently used are released.

    At twelve megapixels those of one size take 0.7 GB.
    """

    def __init__(self, context: moderngl.Context):
        self._context = context
        self._memory: dict[str, NDArray[np.float32]] = {}
        self._buffers: OrderedDict[tuple[int, int], moderngl.Buffer] = OrderedDict()
        self._targets: OrderedDict[tuple[int, int], dict[tuple[int, int, bool], RenderTarget]] = OrderedDict()

    def get(
        self, size: tuple[int, int], channels: int, samples: int = 1, fills_depth: bool = False
    ) -> RenderTarget:
        """The target, made on first use; the parameters are those of `RenderTarget`."""
        of_size = self._targets.setdefault(size, {})
        self._targets.move_to_end(size)
        key = (channels, samples, fills_depth)
        if key not in of_size:
            of_size[key] = RenderTarget(self._context, size, channels, samples, fills_depth)
            self._make_room()
        return of_size[key]

    def scratch(self, name: str, shape: tuple[int, ...]) -> NDArray[np.float32]:
        """Memory to read back into, by name: the same each time, as new memory costs more than to fill it."""
        count = math.prod(shape)
        if name not in self._memory or self._memory[name].size < count:
            self._memory[name] = with_lanes((count,), np.float32)
        return self._memory[name][:count].reshape(shape)

    def buffer(self, size_bytes: int, slot: int) -> moderngl.Buffer:
        """Memory of the device to copy pictures to, by slot: the same for batches of the same size."""
        if (size_bytes, slot) not in self._buffers:
            if len(self._buffers) >= _MOST_BUFFERS:
                self._buffers.popitem(last=False)[1].release()
            self._buffers[size_bytes, slot] = self._context.buffer(reserve=size_bytes)
        self._buffers.move_to_end((size_bytes, slot))
        return self._buffers[size_bytes, slot]

    def _make_room(self) -> None:
        """Release sizes used long ago; a picture takes two, which stay."""
        while len(self._targets) > 2 and (len(self._targets) > _MOST_SIZES or self._nbytes > _MOST_BYTES):
            for target in self._targets.popitem(last=False)[1].values():
                target.release()

    @property
    def _nbytes(self) -> int:
        return sum(target.nbytes for of_size in self._targets.values() for target in of_size.values())
