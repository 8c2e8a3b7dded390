"""Sentences of the report of a diagnosis, made from its numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence

from tacos_gap.answer.findings import Cause, Diagnosis, Parameter, Physical
from tacos_gap.answer.transfer import added
from tacos_gap.hypotheses.effect_names import effect_words
from tacos_gap.statistics.views import view_of
from tacos_report.quantities import number, unit_sign

_NAMED = 5
"""Captures named before the rest are counted."""

_UNITS = {"1": "", "DN^2": "DN²", "um": "µm"}


def captures_in_words(count: int) -> str:
    """So many captures.

    >>> captures_in_words(1), captures_in_words(4)
    ('1 capture', '4 captures')
    """
    return f"{count} capture" if count == 1 else f"{count} captures"


def listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def share(value: float) -> str:
    """A share as a percentage, the sign of nothing but a rounding left out."""
    rounded = round(100 * value)
    return f"{rounded} %".replace("-", "\u2212") if rounded else "0 %"


def headline(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict == "no_gap":
        return "No gap: the captures differ from the simulation by no more than its own noise."
    if not diagnosis.causes:
        where = diagnosis.where[0].statistic if diagnosis.where else diagnosis.unknown.where
        place = f", most of all in: {view_of(where).title.lower()}" if where else ""
        return f"There is a gap{place}, and no effect of the catalogue explains it."
    names = [effect_words(cause.effect) for cause in diagnosis.causes]
    others = [effect_words(name) for name in alternatives(diagnosis)]
    closed = share(diagnosis.closure)
    one = len(names) == 1
    if diagnosis.verdict == "unknown":
        nearest = f"{listed(names)} {'comes' if one else 'come'} nearest"
        return f"The gap is not explained: {nearest} and {'removes' if one else 'remove'} {closed} of it."
    if one and others:
        said = f"{' or '.join([*names, *others])} explains"
        removes = f"these captures cannot tell which. Adding {names[0]} removes {closed} of it"
    else:
        said = f"{listed(names)} {'explains' if one else 'explain'}"
        removes = f"{'adding it removes' if one else 'together they remove'} {closed} of it"
        doubtful = [effect_words(cause.effect) for cause in diagnosis.causes if not cause.is_proven]
        if doubtful and len(doubtful) < len(names):
            removes += f", but {listed(doubtful)} {'is' if len(doubtful) == 1 else 'are'} not proven"
    said = said[:1].upper() + said[1:]
    if diagnosis.verdict == "explained":
        return f"{said} the gap: {removes}."
    return f"{said} part of the gap: {removes}. The rest fits no effect here."


def cause_sentence(cause: Cause) -> str:
    name = " or ".join(effect_words(effect) for effect in (cause.effect, *cause.alike))
    said = [
        f"{_spoken(key, parameter)} {_row(key, parameter)[1]}{_unit_after(parameter)}"
        f"{_interval_after(key, parameter)}"
        for key, parameter in cause.parameters.items()
        if not isinstance(parameter.value, list)
    ]
    sure = f"{cause.present:.2f}"
    sized = f", {listed(said)}" if said else ""
    closes = f"adding it alone closes {share(cause.closure)} of the gap"
    if not cause.is_proven:
        return (
            f"The simulator may lack {name}{sized}: {closes}, but with a score of only {sure} of 1 "
            "it is this, and not something else that looks like it."
        )
    return f"The simulator lacks {name}{sized}: it is there with a score of {sure} of 1, and {closes}."


def _spoken(name: str, parameter: Parameter) -> str:
    """The name of a parameter without the unit, which follows its value: ``radius_px`` becomes ``radius``."""
    unit = re.sub(r"[^a-z0-9]+", "_", parameter.unit.lower().replace("^", "")).strip("_")
    return name.removesuffix(f"_{unit}").replace("_", " ")


def _unit_after(parameter: Parameter) -> str:
    unit = _UNITS.get(parameter.unit, unit_sign(parameter.unit))
    return f" {unit}" if unit else ""


def _interval_after(name: str, parameter: Parameter) -> str:
    return "" if parameter.interval is None else f" ({_row(name, parameter)[2]})"


def picture_remainder(rms_dn: Sequence[float], noise_dn: float, *, explained: bool = True) -> str:
    """Difference that pictures still have, and how much of that noise alone would leave.

    >>> picture_remainder([6.02], 1.25)[:44]
    'The means differ by 6 DN (root mean square);'
    """
    with_causes = f", and by {number(rms_dn[1], 2)} DN with the causes" if len(rms_dn) > 1 else ""
    text = f"The means differ by {number(rms_dn[0], 2)} DN (root mean square){with_causes}; "
    text += f"{number(noise_dn, 2)} DN are noise of the frames themselves, which no simulation removes."
    beyond = max(rms_dn[-1] ** 2 - noise_dn**2, 0.0) ** 0.5
    if len(rms_dn) > 1 and beyond > noise_dn and not explained:
        text += f" The {number(beyond, 2)} DN beyond it are not explained by any effect here."
    elif len(rms_dn) > 1 and beyond > noise_dn:
        text += (
            f" The {number(beyond, 2)} DN beyond it are what the numbers of this page leave out: places off "
            "by parts of a pixel, maps of single specimens, light that differs a little."
        )
    return text


def alternatives(diagnosis: Diagnosis) -> list[str]:
    found = {cause.effect for cause in diagnosis.causes}
    return [name for name in diagnosis.cause_set if name not in found]


def lead(diagnosis: Diagnosis, captures: int) -> str:
    count = f"{captures} captures differ from their" if captures != 1 else "One capture differs from its"
    if diagnosis.verdict == "no_gap":
        before = number(diagnosis.gap_before, 2)
        return (
            f"{count} simulation by {before} times the noise floor, the simulator's difference from itself "
            "with other noise. What lies below the noise floor is not significant."
        )
    before, after = number(diagnosis.gap_before, 3), number(diagnosis.gap_after, 3)
    low, high = (number(end, 2) for end in diagnosis.gap_interval)
    text = f"{count} simulation by {before} times the noise floor, "
    text += "the simulator's difference from itself with other noise. "
    if not diagnosis.causes:
        return f"{text}Nothing was added."
    return (
        f"{text}With the causes below, {after} are left (90 % interval {low} to {high}), measured on "
        "levels, places and captures that neither the effects nor their parameters were chosen by."
    )


def control_sentence(diagnosis: Diagnosis) -> str:
    control = diagnosis.negative_control
    if control is None:
        return ""
    low, high = (share(end) for end in control.interval)
    return (
        f" The negative control chooses {control.effects} of {control.among} effects in the same way, on "
        f"differences that mean nothing: it closes {share(control.closure)} (90 % of controls {low} to "
        f"{high}), and {share(control.p_value)} of the controls at most close as much as the causes."
    )


def not_held_out(diagnosis: Diagnosis) -> list[str]:
    return [
        f"The closure of {effect_words(cause.effect)} is not held out: {cause.not_held_out}."
        for cause in diagnosis.causes
        if cause.not_held_out
    ]


def parameter_rows(name: str, parameter: Parameter) -> list[tuple[str, str, str, str]]:
    """Name, value, 90 % interval and unit of a parameter; below it the same in physical units, by capture."""
    rows = [_row(name, parameter)]
    if parameter.by_capture:
        rows = [(name, rows[0][1], "median of the captures", rows[0][3])]
        rows += [_row(f"{name} in {capture}", own) for capture, own in parameter.by_capture.items()]
    if parameter.physical is not None:
        rows.append(_row(parameter.physical.name, parameter.physical))
    return rows


def _row(name: str, parameter: Parameter | Physical) -> tuple[str, str, str, str]:
    unit = _UNITS.get(parameter.unit, unit_sign(parameter.unit))
    if isinstance(parameter.value, list):
        rows = "; ".join(" ".join(f"{v:.4g}" for v in row) for row in parameter.value)
        return name, rows, "", unit
    value = f"{parameter.value:.4g}" if isinstance(parameter.value, float) else str(parameter.value)
    interval = "not fitted"
    if parameter.interval is not None:
        interval = " to ".join(f"{end:.3g}" for end in parameter.interval)
    minus = "\u2212"
    return name, value.replace("-", minus), interval.replace("-", minus), unit


def cannot_tell(diagnosis: Diagnosis) -> list[str]:
    said = []
    for cause in diagnosis.causes:
        if cause.confused_with:
            others = listed([effect_words(name) for name in cause.confused_with])
            said.append(f"{effect_words(cause.effect).capitalize()} cannot be told from {others} here.")
    if diagnosis.unknown.score >= 0.1 and diagnosis.unknown.where:
        place = view_of(diagnosis.unknown.where).title.lower()
        said.append(
            f"With a score of {diagnosis.unknown.score:.2f} of 1 something is at work that no "
            f"effect here describes. It shows in: {place}."
        )
    if diagnosis.below_floor:
        names = listed([effect_words(name) for name in diagnosis.below_floor])
        said.append(f"Fits slightly, but by too little to count: {names}.")
    return [*said, *gathered(diagnosis.limitations)]


def gathered(limitations: Sequence[str]) -> list[str]:
    """Limitations that several captures share, said once.

    >>> gathered(["a: one frame.", "b: one frame.", "c: too dark."])
    ['a and b: one frame.', 'c: too dark.']
    """
    captures: dict[str, list[str]] = {}
    for limitation in limitations:
        capture, colon, text = limitation.partition(": ")
        captures.setdefault(text if colon else limitation, []).extend([capture] if colon else [])
    return [
        f"{first_of(names)}: {of_many(text) if len(names) > 1 else text}" if names else text
        for text, names in captures.items()
    ]


def first_of(names: Sequence[str]) -> str:
    many = len(names) > _NAMED
    return listed([*names[: _NAMED - 1], f"{len(names) - _NAMED + 1} more"] if many else names)


def of_many(text: str) -> str:
    """A sentence on one capture, said of several.

    >>> of_many("its mask leaves no pixel; it is left out.")
    'their mask leaves no pixel; they are left out.'
    """
    return re.sub(r"\bits\b", "their", re.sub(r"\bit is left out", "they are left out", text))


def of_this_camera(causes: Sequence[Cause]) -> str:
    """Parameters handed on in pixels or file values of the captured camera; empty where none is."""
    found = [f"{effect_words(cause.effect)} ({name})" for cause in causes for name in added(cause).bound]
    if not found:
        return ""
    return (
        f"In pixels and file values of the captured camera: {listed(found)}. For a camera with other pixels "
        "or another gain they need to be scaled."
    )


def remainder(diagnosis: Diagnosis) -> str:
    left = diagnosis.unknown
    chance = left.p_value
    text = f"The rest measures {number(diagnosis.gap_after, 3)} times the noise floor. "
    if left.score < 0.1:
        return f"{text}That is no more than a right model of a real camera leaves."
    fraction = "none of" if chance <= 0.06 else f"{share(chance)} of"
    return (
        f"{text}Of the simulator's comparisons with itself {fraction} them is as extreme: something "
        f"outside of the catalogue remains, with a score of {left.score:.2f} of 1."
    )
