"""What the lens of a camera does to light besides its projection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Camera, ImageContext, ImageGeometry, Settings, Stage, setting
from tacos_plugins.effects.blur import airy_transfer, kernel_of
from tacos_plugins.effects.depth_of_field import blur_by_depth, signed_radius
from tacos_plugins.effects.lens_light import relative_illumination
from tacos_plugins.effects.slight_blur import SLIGHT_PX, blur_in_two_passes, blur_slightly

_REACH_RINGS = 8.0
"""What spreads further, 1.5 % of the light, stays where it is."""

_SHARP_PX = 0.1
"""Discs of a smaller radius, and diffraction of finer detail, take less than 7 % of the contrast of the
finest bars [px]."""


class Lens:
    """Diffraction, depth of field and fall-off, by focal length, projection and f-number of each camera.

    Diffraction is that of a round aperture of the exposure's f-number. Discs out of focus are those of a thin
    lens, which is focused at its hyperfocal distance f^2 / (N c) + f unless `focus_m` says where. Light falls
    off as `relative_illumination` has it: by cos^4 behind a rectilinear lens, to 0 beyond the image circle.

    All are those of a perfect lens; `effect.lens-blur` and `effect.vignetting` have what real ones add.

    Sources: Goodman 2005, "Introduction to Fourier Optics", Sec. 6.3; Potmesil and Chakravarty 1981, "A lens
    and aperture camera model for synthetic image generation", SIGGRAPH; Ray 2002, "Applied photographic
    optics", on hyperfocal distances.
    """

    class Config(Settings):
        wavelength_nm: float | None = setting(
            550.0, help="Wavelength of diffraction; null is none.", unit="nm", ge=100, le=20000
        )
        out_of_focus: float = setting(
            1.0, help="Radius of discs out of focus over that of a thin lens: 0 is all sharp.", ge=0, le=10
        )
        focus_m: float | None = setting(
            None,
            help="Distance of focus; the hyperfocal distance if absent.",
            unit="m",
            gt=0,
            le=1e6,
            also=("focus", "focus_distance"),
        )
        infinity_px: float = setting(
            2.0,
            help="Width c of the disc that infinity makes with a lens at its hyperfocal distance.",
            unit="px",
            gt=0,
            le=100,
        )
        fall_off: float = setting(
            1.0,
            help="Power of the natural fall-off: 0 is none, 0.75 makes cos^3 of cos^4.",
            ge=0,
            le=3,
        )

    stage: ClassVar[Stage] = "optics"
    rank: ClassVar[int] = 35
    neutral: ClassVar[Mapping[str, Any]] = {"wavelength_nm": None, "out_of_focus": 0.0, "fall_off": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ()

    def __init__(self, config: Config) -> None:
        self.config = config

    def origins(self, camera: Camera) -> Mapping[str, str]:
        """See `tacos_framework.contracts.EffectBase.origins`."""
        config, said = self.config, {}
        if config.wavelength_nm is not None:
            said["sharpness"] = "assumed to be limited by diffraction"
        if config.out_of_focus:
            far = "assumed at the hyperfocal distance"
            said["focus"] = far if config.focus_m is None else f"at {config.focus_m:g} m, as the recipe sets"
        if config.fall_off:
            law = "cos^4" if camera.lens.is_rectilinear else f"solid angles, {camera.lens.projection}"
            power = "" if config.fall_off == 1 else f", to the power {config.fall_off:g}"
            said["fall-off"] = f"assumed to be natural ({law}{power})"
        return said

    def on_array(
        self,
        signal: NDArray[np.floating],
        *,
        geometry: ImageGeometry,
        context: ImageContext,
        rng: np.random.Generator,
    ) -> NDArray[np.floating]:
        """Light through the lens; needs the context's f-number, and its depth where not all is sharp."""
        signal = self._out_of_focus(signal, geometry, context)
        signal = self._diffracted(signal, geometry, context)
        if not self.config.fall_off:
            return signal
        return signal * relative_illumination(geometry, self.config.fall_off).astype(signal.dtype)[..., None]

    def _out_of_focus(
        self, signal: NDArray[np.floating], geometry: ImageGeometry, context: ImageContext
    ) -> NDArray[np.floating]:
        if not self.config.out_of_focus:
            return signal
        f_number = context.known_f_number("effect.lens")
        radius_px = self.config.out_of_focus * signed_radius(
            context.known_depth_m("effect.lens with out_of_focus"),
            geometry,
            f_number=f_number,
            focus_m=self._focus_m(geometry, f_number),
        )
        radius_px = np.broadcast_to(radius_px, signal.shape[:3])
        widest_px = float(np.abs(radius_px).max())
        if widest_px < _SHARP_PX:
            return signal
        return (blur_slightly if widest_px <= SLIGHT_PX else blur_by_depth)(signal, radius_px)

    def _focus_m(self, geometry: ImageGeometry, f_number: float) -> float:
        if self.config.focus_m is not None:
            return self.config.focus_m
        focal_length_m = geometry.focal_length_px * geometry.pixel_um * 1e-6
        circle_m = self.config.infinity_px * geometry.pixel_um * 1e-6
        return focal_length_m**2 / (f_number * circle_m) + focal_length_m

    def _diffracted(
        self, signal: NDArray[np.floating], geometry: ImageGeometry, context: ImageContext
    ) -> NDArray[np.floating]:
        if self.config.wavelength_nm is None:
            return signal
        f_number = context.known_f_number("effect.lens")
        detail_px = self.config.wavelength_nm * 1e-3 * f_number / geometry.pixel_um
        if detail_px < _SHARP_PX:
            return signal
        kernel = kernel_of(airy_transfer(1 / detail_px), reach_px=_REACH_RINGS * detail_px)
        return blur_in_two_passes(signal, kernel)
