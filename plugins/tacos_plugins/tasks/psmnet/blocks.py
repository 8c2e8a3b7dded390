"""Convolutions with batch normalisation, the bricks of PSMNet."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional


def conv_2d(
    inputs: int, outputs: int, *, kernel: int = 3, stride: int = 1, dilation: int = 1
) -> nn.Sequential:
    """A convolution that keeps the size but for its stride, then batch normalisation."""
    padding = dilation * (kernel // 2)
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, kernel, stride, padding, dilation, bias=False), nn.BatchNorm2d(outputs)
    )


def conv_3d(inputs: int, outputs: int, *, stride: int = 1) -> nn.Sequential:
    """The same over disparity, row and column."""
    return nn.Sequential(
        nn.Conv3d(inputs, outputs, 3, stride, padding=1, bias=False), nn.BatchNorm3d(outputs)
    )


def doubling_conv_3d(inputs: int, outputs: int) -> nn.Sequential:
    """A transposed convolution that doubles disparity, rows and columns."""
    return nn.Sequential(
        nn.ConvTranspose3d(inputs, outputs, 3, stride=2, padding=1, output_padding=1, bias=False),
        nn.BatchNorm3d(outputs),
    )


class ResidualBlock(nn.Module):
    """Two convolutions around which the input passes; no rectifier after the addition."""

    def __init__(self, inputs: int, outputs: int, *, stride: int = 1, dilation: int = 1) -> None:
        super().__init__()
        self.conv1 = nn.Sequential(conv_2d(inputs, outputs, stride=stride, dilation=dilation), nn.ReLU())
        self.conv2 = conv_2d(outputs, outputs, dilation=dilation)
        same = inputs == outputs and stride == 1
        self.downsample = None if same else conv_2d(inputs, outputs, kernel=1, stride=stride)

    def forward(self, image: Tensor) -> Tensor:
        """(N, outputs, H / stride, W / stride) of (N, inputs, H, W)."""
        kept = image if self.downsample is None else self.downsample(image)
        return self.conv2(self.conv1(image)) + kept


class Hourglass(nn.Module):
    """Down by four and up again over disparity, rows and columns, with ways across at half the size."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        double = 2 * channels
        self.conv1 = nn.Sequential(conv_3d(channels, double, stride=2), nn.ReLU())
        self.conv2 = conv_3d(double, double)
        self.conv3 = nn.Sequential(conv_3d(double, double, stride=2), nn.ReLU())
        self.conv4 = nn.Sequential(conv_3d(double, double), nn.ReLU())
        self.conv5 = doubling_conv_3d(double, double)
        self.conv6 = doubling_conv_3d(double, channels)

    def forward(
        self, cost: Tensor, way_down: Tensor | None = None, way_up: Tensor | None = None
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Refine a cost volume.

        `cost`: (N, channels, D, H, W), sizes divisible by 4. `way_down`, `way_up`: (N, 2 channels, D / 2, H /
        2, W / 2) from hourglasses before: of the first one on its way down, of the last one on its way up.

        Returns: the refinement, shaped as `cost`, and its own two at half the size.
        """
        half = self.conv2(self.conv1(cost))
        down = functional.relu(half if way_up is None else half + way_up)
        quarter = self.conv4(self.conv3(down))
        up = functional.relu(self.conv5(quarter) + (down if way_down is None else way_down))
        return self.conv6(up), down, up
