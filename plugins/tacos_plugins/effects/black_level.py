"""A pedestal other than the simulator believes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tacos_framework import (
    Captures,
    Estimate,
    ImageContext,
    ImageGeometry,
    LookAlike,
    Settings,
    ShownBy,
    Stage,
    of_kind,
    physical,
    setting,
)
from tacos_plugins.effects import closed_forms, observations
from tacos_plugins.effects.darks import pedestal_dn
from tacos_plugins.effects.samples import Moments, Samples
from tacos_plugins.effects.shown_by import DARK


class BlackLevel:
    """Adds a constant to every sample, with the cap on too.

    What the pedestal is believed to be (`FrameBatch.black_level_dn`) stays as it was: that is the error.
    """

    class Config(Settings):
        offset_dn: float = setting(
            0.0, help="Actual minus believed pedestal.", unit="DN", ge=-65535, le=65535
        )
        offset_share: float | None = physical(
            "offset_dn",
            help="The same over the range of the file's codes, for files of any depth.",
            unit="of full scale",
            ge=-1,
            le=1,
        )

    stage: ClassVar[Stage] = "readout"
    rank: ClassVar[int] = 40
    neutral: ClassVar[Mapping[str, Any]] = {"offset_dn": 0.0}
    initial_guesses: ClassVar[Sequence[Mapping[str, Any]]] = ({"offset_dn": 2.0}, {"offset_dn": -2.0})
    look_alikes: ClassVar[Sequence[LookAlike]] = (
        LookAlike(
            "veiling-glare",
            observations.one_scene_no_dark,
            "dark",
            "with the cap on there is no stray light, but still an offset",
        ),
        LookAlike(
            "dark-current",
            observations.one_exposure_no_dark,
            "dark",
            "darks of two exposure times show whether an offset grows with time",
        ),
    )
    shown_by: ClassVar[Sequence[ShownBy]] = (DARK,)

    def __init__(self, config: Config) -> None:
        self.config = config

    @classmethod
    def estimate_from(cls, captures: Captures) -> Iterator[Estimate]:
        """The height of the dark at no exposure above the believed pedestal."""
        if off := closed_forms.pedestal_off_dn(captures):
            yield Estimate("offset_dn", *off, negligible=0.06)

    @classmethod
    def guesses_from(cls, captures: Captures) -> Iterator[Mapping[str, Any]]:
        """The height of the dark at no exposure above the believed pedestal."""
        off = [
            (dark.context.exposure_s, float(dark.real_dn.mean()) - dark.context.black_level_dn)
            for dark in of_kind(captures, "dark")
        ]
        if off:
            yield {"offset_dn": pedestal_dn(min(off), max(off))}

    def on_array(
        self, signal: Samples, *, geometry: ImageGeometry, context: ImageContext, rng: np.random.Generator
    ) -> Samples:
        return signal + self.config.offset_dn if self.config.offset_dn else signal

    def moments(
        self, mean_dn: Samples, variance_dn2: Samples, *, geometry: ImageGeometry, context: ImageContext
    ) -> Moments:
        return mean_dn + self.config.offset_dn, variance_dn2
