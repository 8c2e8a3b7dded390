"""Features of one image: a residual network and a pyramid of pooled contexts."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from tacos_plugins.tasks.psmnet.blocks import ResidualBlock, conv_2d

POOLED_PX = (64, 32, 16, 8)
"""Sizes of the pooled contexts, in pixels of a quarter of the resolution."""


class FeatureExtraction(nn.Module):
    """Features at a quarter of the resolution; both images pass through the same one."""

    def __init__(self, channels: int, *, align_corners: bool) -> None:
        super().__init__()
        self._align_corners = align_corners
        c = channels
        self.firstconv = nn.Sequential(
            *(conv_2d(3, c, stride=2), nn.ReLU(), conv_2d(c, c), nn.ReLU(), conv_2d(c, c), nn.ReLU())
        )
        self.layer1 = _residual(3, c, c)
        self.layer2 = _residual(16, c, 2 * c, stride=2)
        self.layer3 = _residual(3, 2 * c, 4 * c)
        self.layer4 = _residual(3, 4 * c, 4 * c, dilation=2)
        for number, size in enumerate(POOLED_PX, start=1):
            self.add_module(f"branch{number}", _context(size, 4 * c, c))
        self.lastconv = nn.Sequential(
            conv_2d(10 * c, 4 * c), nn.ReLU(), nn.Conv2d(4 * c, c, kernel_size=1, bias=False)
        )

    def forward(self, image: Tensor) -> Tensor:
        """(N, channels, H / 4, W / 4) of (N, 3, H, W), sizes divisible by 4."""
        near = self.layer2(self.layer1(self.firstconv(image)))
        wide = self.layer4(self.layer3(near))
        contexts = [
            functional.interpolate(
                self.get_submodule(f"branch{number}")(wide),
                size=wide.shape[-2:],
                mode="bilinear",
                align_corners=self._align_corners,
            )
            for number in range(len(POOLED_PX), 0, -1)
        ]
        return self.lastconv(torch.cat([near, wide, *contexts], dim=1))


class FittingPool(nn.Module):
    """Average over squares of a size, or over the whole image where that is smaller."""

    def __init__(self, size_px: int) -> None:
        super().__init__()
        self._size_px = size_px

    def forward(self, image: Tensor) -> Tensor:
        """(N, C, H // size, W // size), at least one pixel, of (N, C, H, W)."""
        height, width = image.shape[-2:]
        return functional.avg_pool2d(image, (min(height, self._size_px), min(width, self._size_px)))


def _residual(blocks: int, inputs: int, outputs: int, *, stride: int = 1, dilation: int = 1) -> nn.Sequential:
    first = ResidualBlock(inputs, outputs, stride=stride, dilation=dilation)
    return nn.Sequential(
        first, *(ResidualBlock(outputs, outputs, dilation=dilation) for _ in range(1, blocks))
    )


def _context(size_px: int, inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(FittingPool(size_px), conv_2d(inputs, outputs, kernel=1), nn.ReLU())
