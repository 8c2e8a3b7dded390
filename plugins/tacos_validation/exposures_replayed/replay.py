"""Every exposure of a recording, replayed from every other."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, Progress, Settings, UserError, generator, setting
from tacos_report.page import write_page
from tacos_validation.exposures_replayed.emulation import Lack, Replay
from tacos_validation.exposures_replayed.findings import (
    OTHER_MOMENTS,
    ReplayedExposure,
    SourceFindings,
    replayed,
)
from tacos_validation.exposures_replayed.inliers import Detector, inliers_of_pairs
from tacos_validation.exposures_replayed.pages import page, summary
from tacos_worlds.recorded.motion import Motion, shots_of, steps_between
from tacos_worlds.recorded.noise import measured_noise
from tacos_worlds.recorded.reader import read_recording
from tacos_worlds.recorded.recording import Recording

CONVERSIONS = {
    "RG": cv2.COLOR_BayerRG2GRAY,
    "GR": cv2.COLOR_BayerGR2GRAY,
    "BG": cv2.COLOR_BayerBG2GRAY,
    "GB": cv2.COLOR_BayerGB2GRAY,
}


class ReplayExposures:
    """Replays each exposure of a recording from every other, and ranks them beside the real ones.

    The recording is a folder of raw frames ``NNms_K.png`` (or TIFF, PGM, npy) with ``times.csv`` (file,
    taken_ns) and, where it is known, ``response.txt``. The score is the mean of the inliers of consecutive
    frames.

    Motion, noise and response are measured in the recording: motion and noise of an exposure never in its own
    frames.
    """

    class Config(Settings):
        recording: str = setting("recording", help="Folder of the frames.", min_length=1, is_path=True)
        mosaic: Literal["auto", "RG", "GR", "BG", "GB", "none"] = setting(
            "auto",
            help="Colour filters by OpenCV's names; auto sees whether there are any and where green is, and "
            "takes RG or GR.",
        )
        bit_depth: int | None = setting(
            None, help="Bits per sample; by default what the samples reach.", unit="bit", ge=8, le=16
        )
        detector: Detector = setting("orb", help="Whose features are followed from frame to frame.")
        features: int = setting(2000, help="Features of a frame, the strongest.", ge=8)
        sources_ms: tuple[float, ...] = setting(
            (), help="Exposures to replay from; all of them if none is named.", unit="ms"
        )
        measure: bool = setting(
            True,
            help="Also score the real frames; without, nothing is looked at that `tacos predict` predicts.",
        )

    def __init__(self, config: Config) -> None:
        self.config = config

    def check(self) -> None:
        self._sources(self._read())

    def run(self, *, out: Path, seed: int, progress: Progress) -> Mapping[str, Any]:
        recording = self._read()
        mosaic = recording.mosaic if self.config.mosaic == "auto" else self.config.mosaic
        conversion = CONVERSIONS.get(mosaic)
        light = {name: recording.light(name) for name in recording.exposures}
        progress.phase("Measuring motion", len(light))
        motions, after_middle = motions_without(recording, light, progress)
        count = partial(
            inliers_of_pairs,
            bits=recording.bits,
            conversion=conversion,
            detector=self.config.detector,
            features=self.config.features,
        )
        measured = recording.exposures.items() if self.config.measure else ()
        real = {name: count(frames.codes_dn) for name, frames in measured}
        wanted = self._sources(recording)
        progress.phase("Replaying", len(wanted) * (len(light) - 1))
        period = 1 if conversion is None else 2
        noises = {
            target: measured_noise(
                [own for name, own in light.items() if name != target], mosaic=period, top_dn=recording.top_dn
            )
            for target in light
        }
        sources = {}
        for source in wanted:
            exposures = []
            for target in (name for name in light if name != source):
                replay = Replay(
                    recording,
                    source,
                    target,
                    light[source],
                    noises[target],
                    motions[target],
                    after_middle,
                    period,
                )
                ms = recording.exposures[target].exposure_ms
                truth = float(real[target].mean()) if target in real else None
                progress.step(f"{target} ms from {source} ms")
                if len(replay.moments()) < 2:
                    exposures.append(ReplayedExposure(ms, truth, None, None, OTHER_MOMENTS))
                    continue

                def score(doubled: Lack | None, replay: Replay = replay) -> NDArray[np.float64]:
                    rng = generator(seed, "replay", replay.source, replay.target)
                    return count(replay.frames(rng, doubled))

                worse = {lack: float(score(lack).mean()) for lack in replay.lacks()}
                exposures.append(
                    replayed(ms, truth, score(None), worse, ratio=replay.ratio, blur_px=replay.blur_px)
                )
            sources[source] = SourceFindings(tuple(exposures))
        depth = f"Samples have {recording.bits} bits; mosaic: {mosaic}."
        notes = (recording.response_from, depth, _words_of_stamps(after_middle))
        write_page(out / "report.html", page(sources, notes))
        return {
            "score": f"{self.config.detector}{self.config.features}.inliers",
            "sources": {
                name: {"tau": found.tau, "exposures": [each.as_data() for each in found.exposures]}
                for name, found in sources.items()
            },
            "real": {name: {"inliers": float(v.mean()), "pairs": v.tolist()} for name, v in real.items()},
            "stamp_after_middle": after_middle,
            "notes": list(notes),
            "summary": summary(sources),
        }

    def _read(self) -> Recording:
        return read_recording(self.config.recording, bit_depth=self.config.bit_depth)

    def _sources(self, recording: Recording) -> list[str]:
        """Names of the exposures to replay from. Raises UserError when one is not in the recording."""
        name_of = {frames.exposure_ms: name for name, frames in recording.exposures.items()}
        wanted = self.config.sources_ms or tuple(name_of)
        faults = [
            Fault(
                "sources_ms", f"there is no exposure of {ms:g} ms", ", ".join(f"{own:g}" for own in name_of)
            )
            for ms in wanted
            if ms not in name_of
        ]
        if faults:
            raise UserError(faults)
        return [name_of[ms] for ms in wanted]


def motions_without(
    recording: Recording, light: Mapping[str, NDArray[np.float32]], progress: Progress
) -> tuple[dict[str, Motion], float]:
    """For each exposure the motion that all the others show, and where the stamps lie in the exposure."""
    shots = shots_of(recording, light)
    every = steps_between([shot for own in shots.values() for shot in own])
    after_middle = every.stamp_after_middle()
    motions = {}
    for left_out in shots:
        others = [shot for name, own in shots.items() if name != left_out for shot in own]
        motions[left_out] = steps_between(others).motion(after_middle)
        progress.step(f"without {left_out} ms")
    return motions, after_middle


def _words_of_stamps(after_middle: float) -> str:
    place = {-0.5: "the start", 0.0: "the middle", 0.5: "the end"}[after_middle]
    return f"The stamps are of {place} of the exposures: so the motion is steadiest."
