"""Guide to photographing: the whole round, for one effect, or for what a diagnosis left open."""

from __future__ import annotations

import re
import shlex
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tacos_framework import EffectBase, Fault, UserError, did_you_mean, optional
from tacos_framework.files import read_json
from tacos_gap.captures.missing import FILE, nothing_to_read

DIAGNOSIS = "diagnosis.json"

WIDTH = 100


@dataclass(frozen=True)
class Step:
    """One thing to photograph."""

    kind: str
    minutes: int  # what it takes [min]
    what: str  # to photograph
    how: tuple[str, ...]  # a sentence each
    tells: str  # what it tells


STEPS = (
    Step(
        "dark",
        2,
        "the cap",
        (
            "Cap on, viewfinder covered, room dark.",
            "Four pictures at the exposure time you work with, four at one ten times longer or more.",
        ),
        "black level, read noise, dark current, hot pixels, bad lines",
    ),
    Step(
        "flat",
        4,
        "a wall",
        (
            "Plain paper that fills the view, out of focus, lit from afar; no shadow of yours.",
            "Four pictures each as bright as a fifth, half and four fifths of the scale: dim the lamp, or "
            "take the times for a bracket.",
            "Then four more with the camera turned by 90 degrees: what turns with it is the lens.",
        ),
        "vignetting, shading correction, photon noise, fixed patterns, crosstalk, denoising, flicker",
    ),
    Step(
        "bracket",
        3,
        "any view that stands still, from lamp to shadow",
        (
            "Camera on a tripod or a table; aperture, ISO and light stay.",
            "Two pictures each at four exposure times or more, each double or four times the last, up to "
            "where bright parts clip.",
        ),
        "tone curve, nonlinearity, saturation",
    ),
    Step(
        "edge",
        3,
        "a straight edge of dark on white",
        (
            "A sheet of black paper on white, or a sharp print, in focus, turned by about 5 degrees.",
            "Two pictures with the edge in the middle, two with it in a corner; upright, and then lying.",
            "One of a page of print that fills the picture, taken as the camera takes its pictures: its blur "
            "is told by direction and size.",
        ),
        "lens blur, defocus, motion blur, sharpening, lateral colour",
    ),
    Step(
        "board",
        5,
        "a chessboard, glued to something flat",
        (
            "Five views or more that reach the corners of the picture, tilted by 20 to 40 degrees to "
            "different sides.",
            "The whole board is in every picture, its white border too.",
        ),
        "distortion, focal length",
    ),
    Step(
        "chart",
        3,
        "a ColorChecker, evenly lit",
        (
            "Facing the camera, a quarter of the picture's width or more, no shine on the dark patches.",
            "Two pictures, the white patch just below clipping.",
        ),
        "white balance, colour matrix, tone curve",
    ),
)

PREPARE = (
    "Switch off what adapts: exposure, gain, white balance, focus, lens corrections.",
    "Save RAW, or the least processed files there are. Keep JPEG files as the camera wrote them: they say "
    "how they were coded. What a camera does to pictures before is found, too, but hides the sensor.",
    "Keep focus and zoom; let the camera warm up. Lamps flicker: direct-current LEDs or daylight.",
)


def whole_round() -> Iterator[str]:
    """Lines that say what to photograph, in order."""
    yield f"What to photograph, in {sum(step.minutes for step in STEPS)} minutes"
    yield ""
    yield from (line for text in PREPARE for line in _wrapped(text, "- ", "  "))
    for number, step in enumerate(STEPS, 1):
        yield ""
        yield f"{number}. {step.what} ({step.minutes} min)"
        yield from _details(step)
    yield ""
    yield "All pictures go into one folder. Then: tacos captures import FOLDER --out my_captures"


def for_effect(name: str, effects: Mapping[str, type[Any]]) -> Iterator[str]:
    """Lines that say what shows an effect, and what tells it from others.

    Raises UserError when there is no such effect.
    """
    name = name.removeprefix("effect.")
    if name not in effects:
        expected, remedy = ", ".join(sorted(effects)), did_you_mean(name, effects)
        if Path(name).exists():
            expected, remedy = "an effect, e.g. vignetting", "A diagnosis is named by --for."
        raise UserError(Fault("guide", f"there is no effect {name!r}", expected, remedy))
    needs = [need.remedy for need in getattr(effects[name], "shown_by", ())]
    alike = list(_alike(name, effects))
    yield f"To see {name}"
    yield from (line for need in needs for line in _wrapped(need, "- ", "  "))
    if not needs:
        yield "- any picture that is not dark"
    if alike:
        yield ""
        yield "To tell it from what looks alike"
        for other, kind, why in alike:
            yield from _wrapped(f"{other}: kind {kind}; {why}", "- ", "  ")
    text = " ".join([*needs, *(kind for _, kind, _ in alike)])
    yield from _steps(text)


def for_diagnosis(path: Path, effects: Mapping[str, type[Any]]) -> Iterator[str]:
    """Lines that say what would settle what a diagnosis left open.

    Raises UserError when it is no diagnosis.
    """
    found = _diagnosis(path / DIAGNOSIS if path.is_dir() else path)
    wanted = found.get("next_capture")
    undecided = list(found["cause_set"])
    if wanted is None and len(undecided) < 2:
        yield "The diagnosis leaves nothing open that another capture would settle."
        return
    kinds = []
    if wanted is not None:
        kinds.append(str(wanted["kind"]))
        yield from _wrapped(f"Photograph next: kind {wanted['kind']}; {wanted['why']}.", "", "")
    for name in undecided:
        for other, kind, why in _alike(name, effects):
            if other in undecided and name < other:
                kinds.append(kind)
                yield from _wrapped(f"{name} or {other}: kind {kind}; {why}.", "- ", "  ")
    yield from _steps(" ".join(kinds))


def _diagnosis(path: Path) -> dict[str, Any]:
    if path.name == DIAGNOSIS and path.parent.is_dir() and not path.exists():
        raise UserError(_not_diagnosed(path.parent))
    found = read_json(path, expected=f"the {DIAGNOSIS} of `tacos-run diagnose`")
    if not isinstance(found, dict) or not isinstance(found.get("cause_set"), list):
        raise UserError(Fault(str(path), "is no diagnosis", "the diagnosis.json of `tacos-run diagnose`"))
    return found


def _not_diagnosed(folder: Path) -> Fault:
    remedy = nothing_to_read(folder).remedy
    if (folder / FILE).is_file():
        asked = shlex.quote(f"captures={folder}")
        remedy = f"Diagnose these captures with `tacos-run diagnose --set {asked} --out out`."
    return Fault(str(folder), f"there is no {DIAGNOSIS}", "what `tacos-run diagnose` left in --out", remedy)


def _alike(name: str, effects: Mapping[str, type[Any]]) -> Iterator[tuple[str, str, str]]:
    """Effects that may look like one, the kind that tells them apart, and why; each once."""
    seen = set()
    for own, cls in effects.items():
        for alike in optional(cls, EffectBase, "look_alikes"):
            if name not in (own, alike.effect):
                continue
            other = alike.effect if own == name else own
            if (other, alike.capture) not in seen:
                seen.add((other, alike.capture))
                yield other, alike.capture, alike.why


def _steps(text: str) -> Iterator[str]:
    words = set(re.findall(r"[a-z]+", text))
    for step in STEPS:
        if step.kind in words or f"{step.kind}s" in words:
            yield ""
            yield f"{step.kind}: {step.what} ({step.minutes} min)"
            yield from _details(step)


def _details(step: Step) -> Iterator[str]:
    for sentence in step.how:
        yield from _wrapped(sentence, "   ", "   ")
    yield from _wrapped(f"Tells: {step.tells}.", "   ", "   ")


def _wrapped(text: str, first: str, rest: str) -> Sequence[str]:
    return textwrap.wrap(text, WIDTH, initial_indent=first, subsequent_indent=rest)
