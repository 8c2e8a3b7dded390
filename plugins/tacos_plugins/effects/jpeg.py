"""Frames that went through JPEG."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from statistics import median_low, mode
from typing import Any, ClassVar, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Captures, ImageContext, ImageGeometry, Settings, Stage, setting
from tacos_plugins.effects.samples import Samples

_SAMPLING = {
    "4:4:4": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    "4:2:2": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
    "4:2:0": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}


class Jpeg:
    """Encodes every frame as JPEG and decodes it again.

    Files of more than 8 bits are scaled to 8 for it and back. The images are coded as they are, without a
    tone curve: list `effect.tone-curve` beside it where the camera has one. At a quality of 100 the
    effect is off altogether, though a real encoder still rounds there.

    The blocks of 8 x 8 are pixels of the image it is given, binned or not: the file of a binned camera is
    coded after the binning.

    Source: ITU-T T.81 (1992), baseline process, as libjpeg scales its tables by quality.
    """

    class Config(Settings):
        quality: int = setting(
            100, help="Quality as libjpeg counts it; 100 switches the effect off.", ge=1, le=100
        )
        subsampling: Literal["4:4:4", "4:2:2", "4:2:0"] = setting("4:2:0", help="Resolution of the colours.")
        chroma_offset: int = setting(
            0,
            help="Quality of the colours less `quality`: phones and editors often code them more coarsely.",
            ge=-99,
            le=99,
        )

    stage: ClassVar[Stage] = "codec"
    neutral: ClassVar[Mapping[str, Any]] = {"quality": 100}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = (
        {"quality": 97, "subsampling": "4:2:0"},
        {"quality": 92, "subsampling": "4:2:0"},
        {"quality": 84, "subsampling": "4:2:0"},
        {"quality": 70, "subsampling": "4:2:0"},
        {"quality": 50, "subsampling": "4:2:0"},
        {"quality": 30, "subsampling": "4:2:0"},
        {"quality": 98, "subsampling": "4:4:4"},
        {"quality": 88, "subsampling": "4:4:4"},
        {"quality": 70, "subsampling": "4:4:4"},
    )

    by_capture: ClassVar[Sequence[str]] = ("quality",)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The coding that the files state; the middle qualities of several, and the commonest subsampling."""
        if codings := [each.coding for each in captures if each.coding is not None]:
            quality = median_low(coding.quality for coding in codings)
            offset = median_low(coding.chroma_offset for coding in codings)
            of_colours = {"chroma_offset": offset} if offset else {}
            subsampling = mode(coding.subsampling for coding in codings)
            yield {"quality": quality, "subsampling": subsampling, **of_colours}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        if self.config.quality == 100:
            return signal
        to_bytes = 255 / context.white_level_dn
        coded = np.clip(np.rint(signal * to_bytes), 0, 255).astype(np.uint8)
        decoded = np.empty_like(signal)
        for frame, out in zip(coded, decoded, strict=True):
            out[:] = self._through_jpeg(frame)
        return decoded / to_bytes if to_bytes != 1 else decoded

    def _through_jpeg(self, frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """One (H, W, C) frame, RGB or mono."""
        colour = frame.shape[-1] == 3
        quality = self.config.quality
        options = [cv2.IMWRITE_JPEG_QUALITY, quality]
        if colour:
            of_colours = min(max(quality + self.config.chroma_offset, 1), 100)
            options = [cv2.IMWRITE_JPEG_LUMA_QUALITY, quality, cv2.IMWRITE_JPEG_CHROMA_QUALITY, of_colours]
            options += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, _SAMPLING[self.config.subsampling]]
        _, code = cv2.imencode(".jpg", frame[..., ::-1] if colour else frame, options)
        image = cv2.imdecode(code, cv2.IMREAD_COLOR if colour else cv2.IMREAD_GRAYSCALE)
        decoded = np.asarray(image, np.uint8)
        return decoded[..., ::-1] if colour else decoded[..., None]
