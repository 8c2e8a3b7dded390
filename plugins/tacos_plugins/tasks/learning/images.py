"""From digital frames to the colours that networks take."""

from __future__ import annotations

from typing import Any

import torch
from numpy.typing import NDArray
from torch import Tensor

MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
"""Of ImageNet's sRGB colours, which published weights were made with."""


def network_image(
    image_dn: NDArray[Any], device: torch.device, *, black_level_dn: float, white_level_dn: float
) -> Tensor:
    """A frame in colours of 0..1, on a device; a copy to a GPU goes on while the caller does.

    - `image_dn`: (H, W, C) uint8 or uint16; one channel, or RGB [DN].
    - `device`: where it is wanted.
    - `black_level_dn`, `white_level_dn`: the file's pedestal and full scale [DN].

    Returns: (3, H, W) float32 in 0..1, not normalised by mean and deviation.
    """
    colour = (on_device(image_dn, device).float() - black_level_dn) / (white_level_dn - black_level_dn)
    return colour.clamp(0, 1).permute(2, 0, 1).expand(3, -1, -1)


def normalised(colour: Tensor) -> Tensor:
    """(..., 3, H, W) colours with ImageNet's mean and deviation taken off; to be done once."""
    mean, deviation = (colour.new_tensor(each)[:, None, None] for each in (MEAN, DEVIATION))
    return (colour - mean) / deviation


def on_device(array: NDArray[Any], device: torch.device) -> Tensor:
    copy = torch.from_numpy(array.copy())
    return copy.pin_memory().to(device, non_blocking=True) if device.type == "cuda" else copy
