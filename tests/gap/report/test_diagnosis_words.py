"""What the report of a diagnosis says, from what was found."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tacos_gap.answer.findings import Cause, Diagnosis, Parameter, Physical
from tacos_gap.hypotheses.ambiguity import NextCapture
from tacos_gap.inference.location import Place
from tacos_gap.inference.unknown import Unexplained
from tacos_gap.report import summary, words
from tacos_gap.report.gap_and_causes import parameter_table
from tacos_gap.report.photographed import nuisance_rows, photographed
from tacos_report.page import ContactSheet
from tests.gap.taken import capture

NOTHING_LEFT = Unexplained(0.0, 1.0, 1.0, 0.0, None)
NOT_ASKED: Any = None


def cause(effect: str, shapley: float = 0.9, **changes: Any) -> Cause:
    made = Cause(
        effect=effect,
        present=0.0,
        parameters={"k1": Parameter(-0.31, (-0.33, -0.29), "1")},
        closure=shapley,
        closure_interval=(0.8, 0.95),
        not_held_out="",
        shapley=shapley,
        confused_with=(),
        evidence="",
        settings={},
    )
    return replace(made, **changes)


def found(verdict: str, *causes: Cause, **changes: Any) -> Diagnosis:
    removed = sum(each.closure for each in causes)
    made = Diagnosis(
        verdict=verdict,
        gap_before=14.2,
        gap_after=(14.2**2 - (14.2**2 - 1) * removed) ** 0.5,
        gap_interval=(0.9, 1.3),
        where=[Place("optics", "relative_illumination", 35.1, 0.81, {}, ("flat",))],
        causes=causes,
        cause_set=tuple(each.effect for each in causes),
        unknown=NOTHING_LEFT,
        next_capture=None,
        below_floor=(),
        negative_control=None,
        limitations=(),
        problem=NOT_ASKED,
        attribution=NOT_ASKED,
    )
    return replace(made, **changes)


@pytest.mark.parametrize(
    ("diagnosis", "said"),
    [
        (found("no_gap"), "No gap: the captures differ from the simulation by no more than its own noise."),
        (
            found("explained", cause("vignetting", 0.96)),
            "Vignetting explains the gap: adding it removes 96 % of it.",
        ),
        (
            found("explained", cause("defocus", 0.8), cause("read-noise", 0.14)),
            "Defocus and read noise explain the gap: together they remove 94 % of it.",
        ),
        (
            found("partly_explained", cause("prnu", 0.6)),
            "PRNU explains part of the gap: adding it removes 60 % of it. The rest fits no effect here.",
        ),
        (
            found("unknown", cause("jpeg", 0.2)),
            "The gap is not explained: JPEG comes nearest and removes 20 % of it.",
        ),
        (
            found("unknown"),
            "There is a gap, most of all in: brightness over the image, and no effect of the catalogue "
            "explains it.",
        ),
        (
            found("explained", cause("vignetting"), cause_set=("vignetting", "illumination-gradient")),
            "Vignetting or illumination gradient explains the gap: these captures cannot tell which. "
            "Adding vignetting removes 90 % of it.",
        ),
    ],
)
def test_the_headline_says_the_verdict(diagnosis: Diagnosis, said: str) -> None:
    assert words.headline(diagnosis) == said


def test_the_lead_gives_the_figures() -> None:
    lead = words.lead(found("explained", cause("vignetting"), gap_after=1.1), captures=1)
    assert lead.startswith("One capture differs from its simulation by 14.2 times the noise floor")
    assert "With the causes below, 1.1 are left (90 % interval 0.9 to 1.3)" in lead


def test_limits_name_what_looks_alike_what_is_unknown_and_what_is_too_small() -> None:
    diagnosis = found(
        "partly_explained",
        cause("vignetting", confused_with=("illumination-gradient",)),
        unknown=Unexplained(0.7, 0.06, 4.0, 0.3, "detail"),
        below_floor=("row-noise",),
        limitations=("a: one frame.", "b: one frame."),
        next_capture=NextCapture("flat", "rotated"),
    )
    said = words.cannot_tell(diagnosis)
    assert said[0] == "Vignetting cannot be told from illumination gradient here."
    assert "a score of 0.70 of 1" in said[1]
    assert "contrast of detail" in said[1]
    assert said[2].endswith("row noise.")
    assert said[3] == "a and b: one frame."


def test_limitations_of_many_captures_are_counted() -> None:
    said = words.gathered([f"flat_{i}: too dark." for i in range(30)])
    assert said == ["flat_0, flat_1, flat_2, flat_3 and 26 more: too dark."]


def test_what_is_said_of_many_captures_is_said_in_the_plural() -> None:
    said = words.gathered([f"flat_{i}: its mask leaves no pixel; it is left out." for i in range(2)])
    assert said == ["flat_0 and flat_1: their mask leaves no pixel; they are left out."]


def test_a_parameter_in_a_sentence_has_its_unit_once() -> None:
    blur = cause("lens-blur", parameters={"radius_px": Parameter(1.4, (1.3, 1.5), "px")}, present=0.9)
    assert "lacks lens blur, radius 1.4 px (1.3 to 1.5): it is there" in words.cause_sentence(blur)
    noise = cause("read-noise", parameters={"sigma_e": Parameter(3.0, None, "e-")})
    assert "sigma 3 e" in words.cause_sentence(noise)


def test_the_headline_says_which_of_several_is_not_proven() -> None:
    both = (cause("motion-blur", 0.5, present=0.8), cause("jpeg", 0.1, present=0.0))
    said = words.headline(found("partly_explained", *both))
    assert said.startswith("Motion blur and JPEG explain part of the gap: together they remove")
    assert ", but JPEG is not proven. The rest" in said


def test_effects_that_captures_never_tell_apart_share_a_score_and_are_named_together() -> None:
    blur = cause("defocus", present=0.9, alike=("lens-blur",), confused_with=("lens-blur",))
    assert "lacks defocus or lens blur" in words.cause_sentence(blur)
    diagnosis = found("explained", blur, cause_set=("defocus", "lens-blur", "motion-blur"))
    said = summary.summary(diagnosis)
    assert "defocus or lens-blur (score 0.90)" in said
    assert "cannot be told from: motion-blur" in said


def test_what_fits_and_is_not_proven_is_no_lack_of_the_simulator() -> None:
    said = words.cause_sentence(cause("jpeg", present=0.02))
    assert "may lack" in said
    assert "a score of only 0.02 of 1" in said


def test_a_cause_beside_a_rest_keeps_its_one_number_and_no_ramp_is_called_a_probability() -> None:
    rest = Unexplained(1.0, 0.01, 4.0, 0.3, "detail")
    data = found("partly_explained", cause("lens-distortion", present=0.99), unknown=rest).as_data()
    assert data["causes"][0]["present"] == 0.99
    assert data["unknown"]["score"] == 1.0
    assert data["complete"]["score"] == 0.0
    assert "probability" not in str(data)


def test_captures_that_are_off_alike_share_a_row() -> None:
    sag = {f"board_{i}": {"paper_sag_mm": 0.2349} for i in range(13)}
    assert nuisance_rows(sag) == (("board_0, board_1, board_2, board_3 and 9 more", "paper sag 0.235 mm"),)


def test_parameters_in_pixels_are_said_to_be_of_this_camera() -> None:
    blur = cause("defocus", parameters={"radius_px": Parameter(1.4, (1.3, 1.5), "px")})
    blur = replace(blur, settings={"radius_px": 1.4})
    assert "defocus (radius_px)" in words.of_this_camera([blur])
    assert words.of_this_camera([cause("vignetting", settings={"k1": -0.31})]) == ""


def test_parameters_in_physical_units_stand_below_those_of_the_camera_and_hold_for_others() -> None:
    length = Parameter(1.4, (1.3, 1.5), "px", Physical("radius_um", 4.2, (3.9, 4.5), "um"))
    blur = cause("defocus", parameters={"radius_px": length}, settings={"radius_px": 1.4})
    assert words.parameter_rows("radius_px", length) == [
        ("radius_px", "1.4", "1.3 to 1.5", "px"),
        ("radius_um", "4.2", "3.9 to 4.5", "µm"),
    ]
    assert words.of_this_camera([blur]) == ""


def test_a_parameter_that_was_not_fitted_has_no_interval() -> None:
    assert words.parameter_rows("rounding", Parameter("floor", None, "1"))[0][2] == "not fitted"
    (fitted,) = words.parameter_rows("k1", Parameter(-0.31, (-0.33, -0.29), "1"))
    assert fitted == ("k1", "\u22120.31", "\u22120.33 to \u22120.29", "")


def test_no_column_of_units_stands_empty() -> None:
    turn = words.parameter_rows("k1", Parameter(-0.31, (-0.33, -0.29), "1"))
    length = words.parameter_rows("radius_px", Parameter(1.4, (1.3, 1.5), "px"))
    assert parameter_table(turn).heads == ("parameter", "value", "90 % interval")
    assert parameter_table([*turn, *length]).heads[-1] == "unit"


def test_a_long_exposure_is_told_in_milliseconds_not_in_powers_of_ten() -> None:
    dark = capture("dark", 0.0)
    (sheet, _) = photographed([replace(dark, context=replace(dark.context, exposure_s=3.916))])
    assert isinstance(sheet, ContactSheet)
    assert sheet.pictures[0].caption == "dark_0: 2 frames, 3\u202f916 ms"
