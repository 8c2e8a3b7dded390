"""Settings of the bench: targets and camera."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, model_validator

from tacos_framework import Settings, Use, setting
from tacos_gap.captures.entries import ALSO_CALLED, Kind

Positive = Annotated[float, Field(gt=0)]


@dataclass(frozen=True)
class BenchShot:
    id: str
    kind: Kind
    scene: Use | None  # what is in front of the camera; None behind the cap
    exposure_ms: float
    level: float  # signal of the brightest places over full scale at that time [1]
    frames: int
    group: str | None
    level_uncertainty: float


class BenchCapture(Settings):
    """A capture, or a series of them."""

    id: str = setting(help="Its name; those of a series have the level or time appended.", min_length=1)
    kind: Kind = setting(help="Kind of the capture.")
    scene: Use | None = setting(None, help="Target in front of the camera; none for kind dark.")
    exposure_ms: Positive | tuple[Positive, ...] = setting(
        10.0,
        help="Exposure time; several make a series under the same light.",
        unit="ms",
        also=ALSO_CALLED["exposure_ms"],
    )
    level: Positive | tuple[Positive, ...] = setting(
        0.8,
        help="Signal of the brightest places over full scale at the longest time, to which the lamp is "
        "dimmed; several make a series at the same time. Above 1 it saturates.",
    )
    frames: int = setting(4, help="Frames.", ge=1, le=1000)
    level_uncertainty: float = setting(
        0.0,
        help="Equivalence margin of the level of light: within it a relative difference is no error.",
        ge=0,
        le=1,
    )

    @model_validator(mode="after")
    def _one_series(self) -> BenchCapture:
        if isinstance(self.exposure_ms, tuple) and isinstance(self.level, tuple):
            raise ValueError("a series varies in exposure_ms or in level, not in both")
        if (self.scene is None) != (self.kind == "dark"):
            raise ValueError("every kind but dark needs a scene, and dark has none")
        return self

    def shots(self) -> Iterator[BenchShot]:
        times = self.exposure_ms if isinstance(self.exposure_ms, tuple) else (self.exposure_ms,)
        levels = self.level if isinstance(self.level, tuple) else (self.level,)
        for time_ms in times:
            for level in levels:
                name = self.id
                if len(times) > 1:
                    name += f"_{time_ms:g}ms"
                if len(levels) > 1:
                    name += f"_{100 * level:g}"
                yield BenchShot(
                    id=name,
                    kind=self.kind,
                    scene=self.scene,
                    exposure_ms=time_ms,
                    level=level * time_ms / max(times),
                    frames=self.frames,
                    group=self.id if len(times) > 1 else None,
                    level_uncertainty=self.level_uncertainty,
                )


class BenchSettings(Settings):
    """A camera, what really happens in it, and what it is pointed at."""

    rig: Use = setting(help="The rig; all its variables are given here, and its first camera is used.")
    renderer: Use = setting(help="Renderer of the scenes.")
    reality: Use | None = setting(
        None,
        help="Renderer that takes the place of reality, e.g. {use: renderer.mitsuba, samples: 64}: the "
        "simulator then lacks what its renderer leaves out of the light. Scenes without lamps, as even "
        "fields, stay as they are; by default the renderer.",
    )
    sensor: Use = setting(help="The sensor model.")
    f_number: float = setting(2.8, help="Focal length over aperture.", gt=0, also=ALSO_CALLED["f_number"])
    gain_db: float = setting(0.0, help="Gain.", unit="dB", also=ALSO_CALLED["gain_db"])
    effects: tuple[Use, ...] = setting((), help="Effects of the real camera that the simulator lacks.")
    captures: tuple[BenchCapture, ...] = setting(help="The targets.", min_length=1)

    @model_validator(mode="after")
    def _unique(self) -> BenchSettings:
        counted = Counter(shot.id for shot in self.shots())
        if twice := [name for name, count in counted.items() if count > 1]:
            raise ValueError(f"captures are called {', '.join(twice)} more than once")
        return self

    def shots(self) -> Iterator[BenchShot]:
        for capture in self.captures:
            yield from capture.shots()
