"""An image sensor off the shelf, and what a rig has to know of it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import ConfigDict, model_validator
from pydantic_core import PydanticCustomError

from tacos_framework import Electrons, setting
from tacos_plugins.rigs.priced_part import PricedPart


class SensorPart(PricedPart):
    """The columns of a sensor catalog a rig needs; a row's other columns are ignored."""

    model_config = ConfigDict(extra="ignore")

    name: str = setting("custom", help="Name of the part, for reports.")
    width_px: int = setting(help="Photosites along the long side.", unit="px", ge=1)
    height_px: int = setting(help="Photosites along the short side.", unit="px", ge=1)
    pixel_um: float = setting(
        help="Pitch of the photosites.", unit="um", gt=0, also=("pitch_um", "pixel_size")
    )
    quantum_efficiency: float | None = setting(None, help="Electrons per photon, if known.", gt=0, le=1)
    full_well_e: float | None = setting(
        None, help="Electrons a photosite holds before it saturates, if known.", unit="e-", gt=0
    )
    read_noise_e: float | None = setting(
        None, help="Standard deviation of the noise without light, if known.", unit="e-", ge=0
    )
    dark_current_e_s: float | None = setting(
        None, help="Electrons per second without light, if known.", unit="e-/s", ge=0
    )
    high_gain_from_db: float | None = setting(
        None, help="Gain from which on its higher conversion gain is used, if known.", unit="dB"
    )
    high_gain_read_noise_e: float | None = setting(
        None, help="Read noise at that gain, if known.", unit="e-", ge=0
    )
    black_level_dn: float | None = setting(
        None, help="Digital number without light, at black_level_bits, if known.", unit="DN", ge=0
    )
    black_level_bits: int | None = setting(
        None, help="Bits per sample in which the black level is given.", unit="bit", ge=1, le=24
    )
    red_over_green: float | None = setting(
        None, help="Signal of its red photosites over the green ones', of grey in daylight, if known.", gt=0
    )
    blue_over_green: float | None = setting(None, help="The same of its blue ones, if known.", gt=0)
    colour: Literal["colour", "mono"] | None = setting(
        None, help="Colour filters over its photosites, if known."
    )
    shutter: str | None = setting(
        None, help="Shutter, global (all rows at once) or rolling (one after the other), if known."
    )
    power_w: float | None = setting(
        None, help="Power of a camera that is sold with it, if known.", unit="W", gt=0
    )
    row_time_us: float | None = setting(
        None, help="Time from the read-out of a row to the next, if known.", unit="us", gt=0
    )
    frame_lines: int | None = setting(None, help="Rows of a frame and of its blanking, if known.", ge=1)
    max_fps: float | None = setting(
        None, help="Most frames per second of all its pixels, if known.", unit="1/s", gt=0
    )
    frame_rate_fps: float | None = setting(
        None, help="The same of a camera that is sold with it, if known.", unit="1/s", gt=0
    )
    min_exposure_us: float | None = setting(None, help="Shortest exposure, if known.", unit="us", gt=0)
    bit_depth: str | None = setting(
        None, help="Bits per sample it puts out, if known; the most of several modes count, as in 10/12."
    )
    camera_mass_g: float | None = setting(
        None, help="Mass of a camera that is sold with it, without lens, if known.", unit="g", gt=0
    )
    mounts: str | None = setting(
        None, help="Lens mounts of cameras that are sold with it, as in C, CS, M12; if known."
    )

    @model_validator(mode="before")
    @classmethod
    def _with_units(cls, given: Any) -> Any:
        if isinstance(given, Mapping):
            units = {name.rpartition("_")[0]: name for name in cls.model_fields if "_" in name}
            if column := next((name for name in given if name in units), None):  # would be ignored
                raise PydanticCustomError(
                    "lacks_unit", f"{units[column]}, with its unit, in place of {column}"
                )
        return given

    @model_validator(mode="after")
    def _black_level_leaves_a_range(self) -> Self:
        if (share := self._black_level_share) is not None and share >= 0.5:
            said = f"its black level, {self.black_level_dn:g} DN at {self.black_level_bits} bit, leaves"
            raise ValueError(f"{said} less than half of the range for light")
        return self

    @property
    def width_mm(self) -> float:
        return self.width_px * self.pixel_um * 1e-3

    @property
    def height_mm(self) -> float:
        return self.height_px * self.pixel_um * 1e-3

    @property
    def diagonal_mm(self) -> float:
        return math.hypot(self.width_mm, self.height_mm)

    @property
    def exposes(self) -> str | None:
        """``global``, ``rolling``, or None where the part's shutter is unknown."""
        first = (
            (self.shutter or "").strip().lower().split(" ")[0]
        )  # "rolling (global reset)" needs a dark room
        return first if first in ("global", "rolling") else None

    def region(self, width_share: float, height_share: float) -> SensorPart:
        """The region of interest about its middle, in whole pairs of photosites, as colour patterns need it.

        What lies outside is not read: the field of view shrinks with the image, pixels stay as they are.

        >>> region = SensorPart(width_px=4000, height_px=3000, pixel_um=1.55).region(0.5, 0.3337)
        >>> region.width_px, region.height_px, region.pixel_um
        (2000, 1002, 1.55)
        """
        if width_share == height_share == 1:
            return self
        sizes = {
            name: size_px if share == 1 else max(2, 2 * round(size_px * share / 2))
            for name, size_px, share in (
                ("width_px", self.width_px, width_share),
                ("height_px", self.height_px, height_share),
            )
        }
        return self.model_copy(update=sizes)

    def binned(self, binning: int) -> SensorPart:
        """Its pixels where it averages blocks of photosites; what is left over at the edges is not read.

        Electrons, full well and noise stay those of one photosite.

        >>> binned = SensorPart(width_px=4001, height_px=3000, pixel_um=1.55).binned(2)
        >>> binned.width_px, binned.height_px, binned.pixel_um
        (2000, 1500, 3.1)
        """
        if binning == 1:
            return self
        sizes = {name: max(1, getattr(self, name) // binning) for name in ("width_px", "height_px")}
        return self.model_copy(update={**sizes, "pixel_um": self.pixel_um * binning})

    @property
    def row_time_at_most_us(self) -> float | None:
        """Line time with which its rows just make its frame rate; None where that is not known [us].

        >>> round(SensorPart(width_px=4056, height_px=3040, pixel_um=1.55, max_fps=60).row_time_at_most_us, 2)
        5.48
        """
        rate = max((rate for rate in (self.max_fps, self.frame_rate_fps) if rate is not None), default=None)
        return None if rate is None else 1e6 / (rate * self.height_px)

    @property
    def _black_level_share(self) -> float | None:
        if self.black_level_dn is None or self.black_level_bits is None:
            return None
        return self.black_level_dn / (2**self.black_level_bits - 1)

    @property
    def electrons(self) -> Electrons:
        """Known figures of its photosites in electrons."""
        return Electrons(
            self.name,
            self.quantum_efficiency,
            self.full_well_e,
            self.read_noise_e,
            self.dark_current_e_s,
            self.high_gain_from_db,
            self.high_gain_read_noise_e,
            bits_of(self.bit_depth),
            self._black_level_share,
            self.red_over_green,
            self.blue_over_green,
        )


def bits_of(bit_depth: str | None) -> int | None:
    """The deepest of the modes a part is stated with, as in ``10/12``; None where none is [bit]."""
    return max((int(bits) for bits in re.findall(r"\d+", bit_depth or "")), default=None)
