"""Detection limits as something one can picture, and what one wall cannot tell."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest

from tacos_framework import ImageGeometry
from tacos_framework.plugins import Plugins
from tacos_gap.answer.detection_limits import _beginning, _main
from tacos_gap.hypotheses.candidates import candidates
from tacos_gap.report.limits_in_words import limits_in_words, sentence
from tacos_gap.report.one_wall import of_one_wall
from tests.gap.small_captures import capture, taken

GEOMETRY = ImageGeometry(
    width_px=640,
    height_px=480,
    focal_length_px=500.0,
    centre_px=(319.5, 239.5),
    pixel_um=3.0,
    offset_px=(0, 0),
    full_width_px=640,
    full_height_px=480,
)


def worded(effect: str, **values: float) -> str:
    return limits_in_words({effect: values}, {}, GEOMETRY)[effect]


def test_a_distortion_is_said_as_opencv_moves_the_corner():
    k1 = -0.0051
    corner = np.array([[320 / 500, 240 / 500, 1.0]])
    moved, _ = cv2.projectPoints(corner, np.zeros(3), np.zeros(3), np.eye(3), np.array([k1, 0, 0, 0, 0]))
    share = 1 - np.hypot(*moved.ravel()) / np.hypot(320 / 500, 240 / 500)
    assert worded("lens-distortion", k1=k1) == f"{100 * share:.2g} % at the corner"


@pytest.mark.parametrize(
    ("effect", "values", "said"),
    [
        ("exposure-error", {"scale": 1.0265}, "2.6 % of the light"),
        ("exposure-error", {"scale": 0.9735}, "2.6 % of the light"),
        ("vignetting", {"k1": -0.0121}, "1.2 % of the light at the corner"),
        ("lens-distortion", {"k1": -2e-5}, "less than 0.01 % at the corner"),
        ("focal-length-error", {"scale": 1.0}, "less than 0.01 % of the focal length"),
        ("rolling-shutter", {"row_time_us": 25.0}, "12 ms from the first row to the last"),
        ("lateral-chromatic-aberration", {"red": 0.001}, "0.4 px at the corner"),
        ("defocus", {"radius_px": 0.3141}, "radius 0.31 px"),
        ("black-level", {"offset_dn": -0.053964}, "0.054 DN"),
        ("dark-current", {"rate_dn_s": 79.2}, "79 DN per second of exposure"),
        ("dsnu", {"sigma_dn": 1.13}, "1.1 DN from pixel to pixel"),
        ("sharpening", {"amount": 0.17}, "17 % of the finest detail added again"),
    ],
)
def test_limits_can_be_pictured(effect, values, said):
    assert worded(effect, **values) == said


def test_a_curve_is_said_by_what_it_does_to_the_middle_greys():
    assert (
        worded("tone-curve", gamma=0.99)
        == f"{100 * (0.5**0.99 - 0.5):.2g} % of full scale in the middle greys"
    )
    assert worded("nonlinearity", a2=-0.08) == "2 % of full scale off a straight line"


def test_no_limit_of_the_catalogue_is_a_bare_number():
    """Every limit has a unit or says what it is a share of; what has none is a setting of a program."""
    effects = candidates(Plugins.discover()).effects
    bare = []
    for name, cls in effects.items():
        if (term := _beginning(name, cls)) is not None:
            said = limits_in_words({name: {_main(term): term.theta[0]}}, effects, GEOMETRY)[name]
            if not any(unit in said for unit in ("%", "px", "DN", "ms", "deg", "\u00b0", " s")):
                bare.append(name)
    assert set(bare) <= {"auto-exposure", "auto-white-balance", "defect-lines"}


def test_one_wall_cannot_tell_the_lens_from_the_lamp_and_a_turned_one_can():
    wall = taken([capture("flat", "flat", 100.0)])[0]
    width = wall.valid.shape[1]
    slope = 1 + 0.1 * np.linspace(-1, 1, width)[None, None, :, None]
    found: Any = SimpleNamespace(causes=[SimpleNamespace(effect="vignetting")], cause_set=("vignetting",))
    lit = replace(wall, real_dn=(wall.real_dn * slope).astype(np.float32))
    turned = replace(wall, real_dn=(wall.real_dn * slope[:, :, ::-1]).astype(np.float32))
    (said,) = of_one_wall(found, [lit, lit])
    assert said.startswith("Vignetting: walls taken one way up cannot tell the lens from the lamp.")
    assert of_one_wall(found, [lit, turned]) == []
    other = cast(Any, SimpleNamespace(causes=[SimpleNamespace(effect="prnu")], cause_set=("prnu",)))
    assert of_one_wall(other, [lit]) == []


def test_a_limit_is_a_sentence():
    assert (
        sentence("prnu", "0.4 % from pixel to pixel") == "PRNU of 0.4 % from pixel to pixel would have shown."
    )
