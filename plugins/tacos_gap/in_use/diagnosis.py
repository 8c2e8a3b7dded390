"""Response and motion of a camera in use, from a recording at several exposures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Progress
from tacos_gap.in_use.detail import detail_of
from tacos_gap.in_use.motion import MotionBlur, motion_blur
from tacos_gap.in_use.overlap import Steadiness, Vignetting, overlaps, steadiness, vignetting
from tacos_worlds.recorded.noise import LinearNoise, measured_noise
from tacos_worlds.recorded.reader import read_recording
from tacos_worlds.recorded.recording import ExposedFrames, Recording
from tacos_worlds.recorded.response import PLACES, Response, estimated_response
from tacos_worlds.recorded.source import Source
from tacos_worlds.recorded.times import TIMES

MOTION = "effect.motion-blur"
_QUIET = 0.4
"""Share of the frames of the longest exposure at whose moments the response is found."""
_FEWEST_QUIET = 2
_KNOWN = 0.01
"""Error of light up to which a response counts as known: the bar of a calibrated response [1]."""
_SHORTER = 4.0
"""An exposure is set beside one that is shorter by this factor, so that its motion hardly shows there."""


@dataclass(frozen=True, eq=False)
class InUse:
    """Diagnosis of a camera from a recording."""

    response: Response  # from codes to light, as the exposures have it
    response_error: NDArray[np.float64]
    """(K,) relative error of light at its codes: what parts of the recording contradict each other by [1]."""
    blurs: tuple[MotionBlur, ...]  # for each exposure but the shortest
    noise: LinearNoise  # over linear light of all exposures; texture counts in it where all blocks have some
    vignetting: Vignetting
    steadiness: Steadiness | None  # None where frames do not overlap

    @property
    def causes_in_motion(self) -> dict[str, list[str]]:
        return {f"{blur.exposure_ms:g}": [MOTION] if blur.present else [] for blur in self.blurs}

    @property
    def causes_at_rest(self) -> dict[str, list[str]]:
        unsteady = {f"{b.exposure_ms:g}": b.rest is not None and b.rest[0] > b.rest[1] for b in self.blurs}
        return {name: ["unsteady detail"] if found else [] for name, found in unsteady.items()}

    @property
    def not_separated(self) -> list[list[str]]:
        return [["motion blur", "rolling shutter"]] if any(blur.present for blur in self.blurs) else []

    @property
    def next_picture(self) -> str:
        if self.not_separated:
            return "Pan evenly past a vertical edge: rows read one after the other slant it, blur does not."
        if all(blur.share is None for blur in self.blurs):
            return (
                "Record the same scene in faster motion, at rest before: so far there is too little motion."
            )
        return ""

    def as_data(self) -> dict[str, Any]:
        return {
            "response": {
                "code_dn": self.response.code_dn.tolist(),
                "light_dn": self.response.light_dn.tolist(),
                "relative_error": self.response_error.tolist(),
            },
            "exposures": [{**vars(blur), "present": blur.present} for blur in self.blurs],
            "causes": [
                {"effect": MOTION, "exposure_ms": b.exposure_ms, "share": b.share, "path_px": b.path_px}
                for b in sorted(self.blurs, key=lambda blur: -blur.path_px)
                if b.present
            ],
            "at_rest": self.causes_at_rest,
            "in_motion": self.causes_in_motion,
            "noise": vars(self.noise),
            "vignetting": {**vars(self.vignetting), "present": self.vignetting.present},
            "steadiness": self.steadiness and {**vars(self.steadiness), "cause": self.steadiness.cause},
            "not_separated": self.not_separated,
            "next_picture": self.next_picture,
        }


def is_recording(folder: str | Path) -> bool:
    """True if a folder holds a recording rather than captures beside their simulation."""
    path = Path(folder)
    return (path / TIMES).is_file() and not (path / "captures.yaml").is_file()


def diagnose_recording(folder: str | Path, progress: Progress) -> InUse:
    """Response and motion by the frames of a moving camera; a response that the folder states is ignored.

    Raises UserError with all that is wrong with the folder.
    """
    progress.phase("Finding the response", None)
    recording = read_recording(folder, response="estimated")
    quiet = _quietest(recording)
    stacks = {each.exposure_ms: each.codes_dn for each in quiet.exposures.values()}
    recording = replace(recording, response=estimated_response(stacks, quiet.white_dn))
    error = _response_error(stacks, quiet.white_dn, recording.response)
    source = Source(recording, _mosaic(recording))
    exposures = recording.exposures
    longest_ms = max(each.exposure_ms for each in exposures.values())
    progress.phase("Following the image", len(exposures) - 1)
    blurs = []
    for name, frames in list(exposures.items())[1:]:
        reference = [
            n for n, e in exposures.items() if e.exposure_ms <= frames.exposure_ms / _SHORTER * 1.001
        ]
        beside = reference[-1] if reference else next(iter(exposures))
        details = [
            detail
            for index in range(len(frames.stamp_s))
            if source.motion is not None
            and (detail := detail_of(source, source.motion[0], name, index, beside)) is not None
        ]
        blurs.append(motion_blur(frames.exposure_ms, longest_ms, details))
        progress.step(f"{name} ms")
    progress.phase("Comparing overlaps", None)
    found = overlaps(source)
    lights = [recording.light(name) for name in exposures]
    noise = measured_noise(lights, mosaic=source.mosaic, top_dn=source.top_dn)
    fall_off = vignetting(found)
    return InUse(recording.response, error, tuple(blurs), noise, fall_off, steadiness(found, fall_off))


def _quietest(recording: Recording) -> Recording:
    """The frames of each exposure at the moments when the image moves least: blur changes how brightness is
    spread, and so does a scene that has moved on from exposure to exposure."""
    source = Source(recording, _mosaic(recording))
    if source.motion is None:
        return recording
    middle_s = {
        name: np.array([source.middle_s(name, i) for i in range(len(frames.stamp_s))])
        for name, frames in recording.exposures.items()
    }
    longest_s = [*middle_s.values()][-1]
    speeds = [float(np.linalg.norm(source.motion[0].at(s), axis=-1).mean()) for s in longest_s]
    count = max(_FEWEST_QUIET, round(_QUIET * len(speeds)))
    moments_s = longest_s[np.argsort(speeds, kind="stable")[:count]]
    kept = {}
    for name, frames in recording.exposures.items():
        chosen = np.unique(np.abs(middle_s[name][:, None] - moments_s).argmin(0))
        kept[name] = ExposedFrames(frames.exposure_ms, frames.stamp_s[chosen], frames.codes_dn[chosen])
    return replace(recording, exposures=kept)


def _mosaic(recording: Recording) -> int:
    return 1 if recording.mosaic == "none" else 2


def _response_error(
    stacks: Mapping[float, NDArray[np.uint16]], white_dn: int, found: Response
) -> NDArray[np.float64]:
    """(K,) half of what two halves of the frames, or of the colours, differ by in light, and what the longest
    and the shortest exposure change, whichever is most [1]."""
    halves = [
        [estimated_response({t: c[i::2] for t, c in stacks.items()}, white_dn) for i in (0, 1)],
        [estimated_response(stacks, white_dn, pair) for pair in (PLACES[::3], PLACES[1:3])],
    ]
    apart = [_apart(first, second) / 2 for first, second in halves]
    times = sorted(stacks)
    for kept in (times[1:], times[:-1]) if len(times) > 2 else ():
        apart.append(_apart(found, estimated_response({t: stacks[t] for t in kept}, white_dn)))
    return np.asarray(np.max(apart, axis=0))


def _apart(first: Response, second: Response) -> NDArray[np.float64]:
    """(K,) relative difference in light; brightness that all codes have in common is free [1]."""
    apart = np.log(np.maximum(first.light_dn[1:], 1e-9) / np.maximum(second.light_dn[1:], 1e-9))
    apart -= np.median(apart)
    return np.asarray(np.abs(np.concatenate([apart[:1], apart])))


def in_words(found: InUse) -> str:
    lines = [_of_response(found)]
    lines += [_of_blur(blur) for blur in found.blurs]
    lines += [_of_noise(found), _of_vignetting(found.vignetting), _of_steadiness(found.steadiness)]
    unsteady = [name for name, causes in found.causes_at_rest.items() if causes]
    at = f"unsteady detail named at {', '.join(unsteady)} ms" if unsteady else "nothing named"
    lines.append(f"At rest: {at}.")
    lines += [f"Not separable: {' and '.join(each)}." for each in found.not_separated]
    return "\n".join([*lines, found.next_picture]).strip()


def _of_response(found: InUse) -> str:
    codes = found.response.code_dn / found.response.code_dn[-1]
    inside = (codes >= 0.05) & (codes <= 0.95)
    error, codes = found.response_error[inside], codes[inside]
    said = f"Response found from the exposures, light within {error.max():.1%} from 5 to 95 % of the codes"
    longest = max(np.split(np.arange(len(codes)), np.flatnonzero(error > _KNOWN)), key=len)[1:]
    if error.max() <= _KNOWN or not len(longest):
        return f"{said}."
    low, high = codes[longest[0]], codes[longest[-1]]
    return f"{said}, within {_KNOWN:.0%} from {low:.0%} to {high:.0%}: beyond, exposures or colours disagree."


def _of_blur(blur: MotionBlur) -> str:
    where = f"{blur.exposure_ms:g} ms: {blur.frames_at_rest} frames at rest, {blur.frames_moving} in motion"
    if blur.share is None or blur.interval is None:
        return f"{where}; too little motion to decide."
    low, high = blur.interval
    share = (
        f"{blur.share:.2f} ({low:.2f} to {high:.2f}) of the blur that a path of {blur.path_px:.1f} px makes"
    )
    return f"{where}; {'motion' if blur.present else 'nothing'} named: {share}."


def _of_noise(found: InUse) -> str:
    return (
        f"Noise of linear light, at most: variance {found.noise.floor_dn2:.3g} DN² + "
        f"{found.noise.slope_dn:.3g} DN x light, white at {found.response.light_dn[-1]:g} DN."
    )


def _of_vignetting(found: Vignetting) -> str:
    if found.interval is None:
        return "Vignetting: the image moves too little between frames to tell."
    low, high = found.interval
    named = f"named: corners lack {found.corner:.0%}" if found.present else "not named"
    return f"Vignetting {named} ({low:.0%} to {high:.0%})."


def _of_steadiness(found: Steadiness | None) -> str:
    if found is None:
        return "Brightness: too few frames overlap to tell if it is steady."
    of_frames, of_rows = found.limits
    return (
        f"Brightness from frame to frame: {found.cause or 'nothing'} named. It changes by "
        f"{found.largest:.1%} (limit {of_frames:.1%}), over rows by {found.bands:.1%} (limit {of_rows:.1%})."
    )


def data_and_summary(found: InUse) -> Mapping[str, Any]:
    return {"diagnosis": found.as_data(), "summary": in_words(found)}
