"""Physical effects of real cameras."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Protocol, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from tacos_framework.settings import Settings
from tacos_framework.values import Capture, Exposure, FrameBatch, ImageContext, ImageGeometry, Rig, Signal

Stage = Literal["scene", "optics", "exposure", "pixel", "readout", "isp", "codec"]
"""Where in image formation an effect acts; the noise lies between pixel and readout."""

STAGES: tuple[Stage, ...] = get_args(Stage)
"""The stages in the order of image formation."""


Image = TypeVar("Image", Capture, Signal, FrameBatch)


class Effect(Protocol[Image]):
    """One physical effect of a real camera.

    ``neutral`` gives, for each parameter, the value at which the effect is exactly off. Effects of the
    stages scene, optics and exposure change a `Capture`; pixel and readout a `Signal`; isp and codec a
    `FrameBatch`.

    The physics of an effect stands in `on_array`, on plain arrays, and `apply` brings it to the views of a
    capture, signal or batch; the diagnosis of real captures calls `on_array` itself. At the neutral values
    both hand on the very object they were given.

    Further members are optional:

    ``after_noise: ClassVar[bool]``
        True for an effect of the stage pixel that acts on noisy samples: electrons that are lost or shared
        once they are counted. It then follows the noise, ahead of the effects of the stage readout.
    ``rank: ClassVar[int]``
        The order within a stage, lower first; 0 by default. Equal ranks act in the recipe's order.
    ``photon_scale: float``
        Factor on the variance of the photon noise, for an effect that changes the noise and not the signal.
    ``probes: ClassVar[Sequence[Mapping[str, Any]]]``
        Severities met in the field, where a diagnosis begins its search; parameters given as floats are then
        fitted. An effect without is tried a little to either side of neutral, one with ``()`` only where the
        captures point to it.
    ``plausible: bool``
        False for settings that no camera has, as a lens that brightens its corners. Recipes may have them, a
        diagnosis does not propose them.
    ``source(geometry)``
        For an effect that only moves pixels: (H, W) columns and rows where each pixel of the image looks in
        the image without it.
    ``moments(mean_dn, variance_dn2, *, geometry, context)``
        Mean and variance of the noise after the effect, from those before it, where a closed form exists; so
        that a diagnosis need not draw samples. Both are arrays of the shape (N, H, W, C), or flat fields that
        broadcast to it.
    """

    Config: ClassVar[type[Settings]]
    stage: ClassVar[Stage]
    neutral: ClassVar[Mapping[str, Any]]

    def apply(self, image: Image, *, rig: Rig, exposure: Exposure, rng: np.random.Generator) -> Image:
        """The image with the effect."""
        ...

    def on_array(
        self,
        signal: NDArray[Any],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[Any]:
        """Samples with the effect.

        Parameters
        ----------
        signal
            (N, H, W, C) float32 or float64 frames of one camera, C = 1 or 3; left as they are. For the
            stages scene, optics and exposure light in any linear unit, 0 is darkness; for pixel and readout
            samples with the pedestal, neither rounded nor clipped [DN]; for isp and codec the values of the
            file [DN].
        geometry
            Where the pixels lie on the sensor.
        context
            What else is known; `ContextMissing` is raised where it is not enough for these settings.
        rng
            Draws what is random.

        Returns
        -------
        Same shape and dtype.
        """
        ...


def acts_after_noise(effect: type[Any]) -> bool:
    """Whether an effect acts on noisy samples, which correlates noise, rather than on expected light."""
    return getattr(effect, "after_noise", False) or STAGES.index(effect.stage) > STAGES.index("pixel")


def formation_order(effect: type[Any]) -> tuple[int, bool, int]:
    """Where an effect class stands in image formation: sort effects by it, and each acts at its place.

    Whatever order a recipe or a diagnosis lists effects in, white balance then comes before the tone curve.
    """
    return STAGES.index(effect.stage), acts_after_noise(effect), getattr(effect, "rank", 0)
