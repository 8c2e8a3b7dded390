"""PSMNet with stacked hourglasses."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from tacos_plugins.tasks.psmnet.blocks import Hourglass, conv_3d
from tacos_plugins.tasks.psmnet.features import FeatureExtraction

CHANNELS = 32
"""Channels of the published network, whose other layers have two and four times as many."""

MULTIPLE_PX = 16
"""Images and disparities are worked on in multiples of this: a quarter, halved twice [px]."""

PUBLISHED_PARAMETERS = 5_224_768
"""Parameters of the published network: that of width 1."""


class PSMNet(nn.Module):
    """The disparity of each pixel of the left image.

    Features of both images are set side by side at each disparity of a cost volume, which three stacked
    hourglasses refine. The disparity is the mean over all disparities, weighted by the softmax of the
    volume (soft argmin).

    - `max_disparity`: disparities 0 .. max_disparity - 1 are told apart; a multiple of 16 [px].
    - `width`: factor on the channels of all layers; 1 is the published network [1].
    - `align_corners`: how the volume is enlarged; the authors advise True for their published weights.

    Source: Chang and Chen 2018, "Pyramid stereo matching network", CVPR. Written anew from the published
    architecture; entries carry the names of the published checkpoints.

    >>> network = PSMNet(192)
    >>> sum(parameter.numel() for parameter in network.parameters())
    5224768
    """

    def __init__(self, max_disparity: int, *, width: float = 1.0, align_corners: bool = True) -> None:
        super().__init__()
        if max_disparity < MULTIPLE_PX or max_disparity % MULTIPLE_PX:
            raise ValueError(f"max_disparity must be a multiple of {MULTIPLE_PX}, not {max_disparity}")
        self.max_disparity = max_disparity
        self.align_corners = align_corners
        c = max(1, round(CHANNELS * width))
        self.feature_extraction = FeatureExtraction(c, align_corners=align_corners)
        self.dres0 = nn.Sequential(conv_3d(2 * c, c), nn.ReLU(), conv_3d(c, c), nn.ReLU())
        self.dres1 = nn.Sequential(conv_3d(c, c), nn.ReLU(), conv_3d(c, c))
        self.dres2, self.dres3, self.dres4 = Hourglass(c), Hourglass(c), Hourglass(c)
        self.classif1, self.classif2, self.classif3 = _head(c), _head(c), _head(c)
        self.apply(_initialise)

    def forward(self, left: Tensor, right: Tensor) -> list[Tensor]:
        """Disparities of the left image.

        `left`, `right`: (N, 3, H, W) normalised images.

        Returns: (N, H, W) float32 disparities [px]: in training those after each of the three hourglasses,
        else those after the last alone.
        """
        height, width = left.shape[-2:]
        padding = (0, -width % MULTIPLE_PX, 0, -height % MULTIPLE_PX)
        both = functional.pad(torch.cat([left, right]), padding, mode="replicate")
        features_left, features_right = self.feature_extraction(both).chunk(2)
        volumes = self._refined(cost_volume(features_left, features_right, self.max_disparity // 4))
        wanted = volumes if self.training else volumes[-1:]
        size = (self.max_disparity, *both.shape[-2:])
        return [self._disparity(volume, size)[:, :height, :width] for volume in wanted]

    def _refined(self, cost: Tensor) -> list[Tensor]:
        """(N, 1, D, H, W) likelihoods after each hourglass, up to a constant and the exponential."""
        start = self.dres0(cost)
        start = self.dres1(start) + start
        first, down, up = self.dres2(start)
        first = first + start
        second, _, up = self.dres3(first, down, up)
        second = second + start
        third, _, _ = self.dres4(second, down, up)
        third = third + start
        one = self.classif1(first)
        two = self.classif2(second) + one
        return [one, two, self.classif3(third) + two]

    def _disparity(self, volume: Tensor, size: tuple[int, ...]) -> Tensor:
        """(N, H, W) disparities of a volume of a quarter of the size [px]."""
        with torch.autocast(volume.device.type, enabled=False):  # eight bits cannot tell 150 from 150.4
            fine = functional.interpolate(
                volume.float(), size=size, mode="trilinear", align_corners=self.align_corners
            )
            return soft_argmax(fine.squeeze(1))


def cost_volume(left: Tensor, right: Tensor, disparities: int) -> Tensor:
    """Features of both images side by side, at each disparity.

    `left`, `right`: (N, C, H, W). `disparities`: how many, counted from 0 [px].

    Returns: (N, 2 C, disparities, H, W); zero where a disparity leads out of the right image.
    """
    count, channels, height, width = left.shape
    volume = left.new_zeros(count, 2 * channels, disparities, height, width)
    for disparity in range(min(disparities, width)):
        volume[:, :channels, disparity, :, disparity:] = left[..., disparity:]
        volume[:, channels:, disparity, :, disparity:] = right[..., : width - disparity]
    return volume


def soft_argmax(volume: Tensor) -> Tensor:
    """The mean disparity under the softmax of a volume.

    `volume`: (N, D, H, W) logarithms of likelihoods, up to a constant.

    Returns: (N, H, W), in 0 .. D - 1 [px].
    """
    disparities = torch.arange(volume.shape[1], dtype=volume.dtype, device=volume.device)
    shares = functional.softmax(volume, dim=1)
    return torch.matmul(disparities, shares.flatten(2)).unflatten(1, volume.shape[-2:])


def _head(channels: int) -> nn.Sequential:
    return nn.Sequential(
        conv_3d(channels, channels), nn.ReLU(), nn.Conv3d(channels, 1, 3, padding=1, bias=False)
    )


def _initialise(module: nn.Module) -> None:
    """Weights of variance 2 / (outputs x kernel), as the published network starts (He et al. 2015)."""
    if isinstance(module, nn.Conv2d | nn.Conv3d):
        nn.init.kaiming_normal_(module.weight, mode="fan_out", nonlinearity="relu")
