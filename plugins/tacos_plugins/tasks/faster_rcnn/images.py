"""From digital frames to what a detector takes: colour in 0..1, in the network's size."""

from __future__ import annotations

from torch import Tensor
from torch.nn.functional import interpolate, pad
from torchvision.models.detection.transform import GeneralizedRCNNTransform

from tacos_plugins.tasks.learning.images import DEVIATION, MEAN

SMALLEST_PX = 64
"""Images are padded to this, so that batch normalisation has several values even at a stride of 32 [px]."""


class CameraPixels(GeneralizedRCNNTransform):
    """Normalises and pads images, and resizes them only where it is asked for.

    torchvision's own brings every image to a short side of 800 pixels, whatever the camera's.

    - `scale`: size of the network's image over the camera's.
    - `min_size_px`, `max_size_px`: least short side and most long side of the network's image; None sets
      none. The latter wins [px].
    """

    def __init__(self, scale: float, min_size_px: int | None, max_size_px: int | None):
        super().__init__(1, 1, list(MEAN), list(DEVIATION))
        self.scale, self.least_px, self.most_px = scale, min_size_px, max_size_px

    def factor(self, height_px: int, width_px: int) -> float:
        """Size of the network's image over that of a camera of so many pixels."""
        factor = self.scale
        if self.least_px is not None:
            factor = max(factor, self.least_px / min(height_px, width_px))
        if self.most_px is not None:
            factor = min(factor, self.most_px / max(height_px, width_px))
        return factor

    def resize(
        self, image: Tensor, target: dict[str, Tensor] | None = None
    ) -> tuple[Tensor, dict[str, Tensor] | None]:
        """An image, (3, H, W), and its boxes in the network's size."""
        height, width = image.shape[-2:]
        factor = self.factor(height, width)
        if factor == 1:
            return image, target
        size = (max(1, round(height * factor)), max(1, round(width * factor)))
        image = interpolate(image[None], size, mode="bilinear", antialias=factor < 1)[0]
        if target is not None:
            across, down = size[1] / width, size[0] / height
            edges = target["boxes"].new_tensor([across, down, across, down])
            target = {**target, "boxes": target["boxes"] * edges}
        return image, target

    def batch_images(self, images: list[Tensor], size_divisible: int = 32) -> Tensor:
        """Images of any sizes in one tensor, (N, 3, H, W), zeros to their right and below them."""
        batch: Tensor = super().batch_images(images, size_divisible)
        height, width = (max(0, SMALLEST_PX - size) for size in batch.shape[-2:])
        return pad(batch, (0, width, 0, height))
