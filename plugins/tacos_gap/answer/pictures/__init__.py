"""Pictures held against their expectation pixel by pixel, once they lie on each other."""

from tacos_gap.answer.pictures.explained import share_of_pictures
from tacos_gap.answer.pictures.misfit import tile_squares
from tacos_gap.answer.pictures.overlay import Overlay, laid_over

__all__ = ["Overlay", "laid_over", "share_of_pictures", "tile_squares"]
