"""Physical effects of real cameras."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from tacos_framework.contracts.observed import LookAlike, ShownBy
from tacos_framework.contracts.optional import optional
from tacos_framework.settings import Settings
from tacos_framework.values import ImageContext, ImageGeometry

Stage = Literal["scene", "optics", "exposure", "pixel", "readout", "isp", "codec"]
"""Place of an effect in image formation; the noise lies between pixel and readout."""

STAGES: tuple[Stage, ...] = get_args(Stage)
"""The stages in the order of image formation."""

LIGHT_STAGES: tuple[Stage, ...] = ("scene", "optics", "exposure")
"""The stages that act on light, before there is a pixel."""

FILE_STAGES: tuple[Stage, ...] = ("isp", "codec")
"""The stages that act on digital images."""


class Effect(Protocol):
    """One physical effect of a real camera.

    ``neutral`` gives, for each parameter, the value at which the effect is exactly off. An effect is written
    on plain arrays of one camera; the framework brings it to captures, to the samples inside a sensor and to
    frames, by its stage. One that does nothing but move pixels has, in place of `on_array`,

    ``source(*, geometry, context, frames) -> (columns, rows) | None``
        Where each pixel of the image looks in the image without the effect, (H, W) or (frames, H, W) [px];
        None where the effect is off. Light, depth and ids then come from there, so that truth stays true.
    ``source_at(x_px, y_px, *, geometry) -> (x_px, y_px)``
        Optional beside it: the same for any points, exactly and without a map.
    ``moved_inverse_depth(near, columns, rows, *, geometry) -> near``
        Optional beside it, for a camera that stands elsewhere: the inverse depth of what is seen, from that
        fetched from those places [1/m].

    Settings in pixels or digital numbers may have a physical counterpart, declared by
    `tacos_framework.settings.physical`. The framework turns physical values into those of the image at hand
    and takes account of binning before an effect is called: it sees pixels and digital numbers of the image
    it is given.

    `EffectBase` has the optional members, those among them that a diagnosis reads.
    """

    Config: ClassVar[type[Settings]]
    stage: ClassVar[Stage]
    neutral: ClassVar[Mapping[str, Any]]

    def on_array(
        self,
        samples: NDArray[Any],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[Any]:
        """Samples with the effect; at the neutral values the very array that was given.

        - `samples`: (N, H, W, C) float32 or float64 frames of one camera, C = 1 or 3; left as they are. For
          the stages scene, optics and exposure light in any linear unit, 0 is darkness; for pixel and readout
          samples with the pedestal, neither rounded nor clipped [DN]; for isp and codec the values of the
          file [DN]. Frames come one by one, N = 1, but for effects that a caller applies himself.
        - `geometry`: where the pixels lie on the sensor.
        - `context`: what else is known; `ContextMissing` is raised where it is not enough for these settings.
        - `rng`: draws what is random. Every frame has a generator of its own.

        Returns: same shape and dtype.
        """
        ...


class EffectBase:
    """Optional members of an `Effect`, with their defaults."""

    after_noise: ClassVar[bool] = False
    """True for an effect of the stage pixel that acts on noisy samples: electrons that are lost or shared
    once they are counted. It then follows the noise, ahead of the effects of the stage readout."""
    rank: ClassVar[int] = 0
    """The order within a stage, lower first. Equal ranks act in the recipe's order."""
    photon_scale: float = 1.0
    """Factor on the variance of the photon noise, for an effect that changes the noise and not the
    signal."""
    dark_scale: Callable[..., float] | None = None
    """``dark_scale(context) -> float``: factor on the variance of the noise without light, at that gain."""
    source: Callable[..., Any] | None = None
    """Places at which pixels look in the image without the effect; see `Effect`."""
    source_at: Callable[..., Any] | None = None
    """The same for any points."""
    moved_inverse_depth: Callable[..., Any] | None = None
    """The inverse depth of what is seen from another place [1/m]; see `Effect`."""
    of_colours: ClassVar[bool] = False
    """True for an effect on colours alone, which images of one channel pass by."""
    codes: bool = False
    """True if files leave it coded for a display, where they were linear."""
    on_view: Callable[..., Any] | None = None
    """``on_view(light, depth_m, object_id, *, geometry, context) -> (light, depth_m, object_id)`` beside
    `on_array`, for an effect on light that also moves what pixels show: all three of one rendered frame with
    the effect, (1, H, W, 3) and (1, H, W); the very arrays where it is off."""
    lacks: Callable[..., Any] | None = None
    """``lacks(rig) -> str | None``: what the effect would have to know of a rig's cameras and does not, in a
    sentence. A recipe none of whose cameras it can serve is refused with it; a candidate it cannot serve
    fails."""
    origins: Callable[..., Any] | None = None
    """``origins(camera) -> {figure: origin}``, as those of a sensor (`SensorBase.origins`)."""
    moments: Callable[..., Any] | None = None
    """``moments(mean_dn, variance_dn2, *, geometry, context)``: mean and variance of the noise after the
    effect, from those before it, where a closed form exists. Arrays of the shape (N, H, W, C), or flat
    fields that broadcast to it."""

    initial_guesses: ClassVar[Sequence[Mapping[str, Any]] | None] = None
    """Severities met in the field, where a diagnosis begins its search; parameters given as floats are then
    fitted. An effect without is tried a little to either side of neutral, one with ``()`` only where the
    captures point to it."""
    guesses_from: ClassVar[Callable[..., Any] | None] = None
    """``guesses_from(captures) -> Iterable[Mapping[str, Any]]``, a class method: further initial guesses
    that the captures suggest, for an effect to which nothing points far from the truth."""
    estimate_from: ClassVar[Callable[..., Any] | None] = None
    """``estimate_from(captures) -> Iterable[Estimate]``, a class method: closed forms, one for each parameter
    that captures tell of by arithmetic. A diagnosis begins with the effects that are surely there, and does
    not look for one whose estimates all are surely negligible."""
    by_capture: ClassVar[Sequence[str]] = ()
    """Settings a camera sets anew for each picture, as its focus. Where several captures show the effect, a
    diagnosis may fit a value for each; it asks ``guesses_from`` of each capture by itself."""
    frames_differ: ClassVar[bool] = False
    """True where luck decides what each frame shows, as the phase of a lamp does. A diagnosis then counts how
    far frames spread as part of what the effect predicts."""
    series: ClassVar[Sequence[Sequence[str]]] = ()
    """Coefficients of rising powers, lowest first. A diagnosis drops the highest that it does not need first:
    without a lower one the others would take its part."""
    look_alikes: ClassVar[Sequence[LookAlike]] = ()
    """Effects that some captures cannot tell from this one. It holds both ways."""
    shown_by: ClassVar[Sequence[ShownBy]] = ()
    """The captures it takes to speak of it."""
    plausible: bool = True
    """False for settings that no camera has, as a lens that brightens its corners. Recipes may have them, a
    diagnosis does not propose them."""


def acts_after_noise(effect: type[Any]) -> bool:
    """True if an effect acts on noisy samples, which correlates noise, rather than on expected light."""
    return optional(effect, EffectBase, "after_noise") or STAGES.index(effect.stage) > STAGES.index("pixel")


def formation_order(effect: type[Any]) -> tuple[int, bool, int]:
    """Key of an effect class in image formation: sort effects by it, and each acts at its place.

    Whatever order a recipe or a diagnosis lists effects in, white balance then comes before the tone curve.
    """
    return STAGES.index(effect.stage), acts_after_noise(effect), optional(effect, EffectBase, "rank")


def moves_pixels(effect: type[Any]) -> bool:
    """True if an effect class does nothing but move pixels, and says from where."""
    return callable(optional(effect, EffectBase, "source"))
