"""Sets that captures cannot tell apart, and the capture that would."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tacos_framework.plugins import Plugins
from tacos_gap.answer.next_capture import _SHOWN_BY, best_capture
from tacos_gap.captures import RealCapture
from tacos_gap.evidence.boards import source_of
from tacos_gap.hypotheses.ambiguity import confused_with
from tacos_gap.hypotheses.candidates import candidates
from tacos_gap.hypotheses.parameters import HypothesisTerm
from tacos_gap.statistics.views import _VIEWS
from tests.gap.small_captures import BLACK_DN, bench, capture, squares

EFFECTS = candidates(Plugins.discover()).effects


def flat(frames: int = 1) -> RealCapture:
    return capture("flat", "flat", BLACK_DN + 100, frames)


def board(name: str) -> RealCapture:
    return replace(capture(name, "board", 0.0, 1), expected_dn=None)


def moving(velocity: tuple[float, float], frames: int = 1) -> RealCapture:
    still = capture(f"moving {velocity}", "sequence", squares(), frames)
    field = np.broadcast_to(np.float32(velocity), (*still.valid.shape, 2))
    return replace(still, context=replace(still.context, velocity_px_s=field))


SCENE = capture("scene", "scene", squares(), 1)
EDGE = replace(capture("edge", "edge", squares(), 1), edge_angle_deg=5.0)


@pytest.mark.parametrize(
    ("effect", "other", "captures", "wanted"),
    [
        ("vignetting", "illumination-gradient", [flat()], "flat"),
        ("vignetting", "lens-shading-correction", [flat()], "flat"),
        ("prnu", "conversion-gain-error", [flat(), replace(flat(), id="brighter")], "flat"),
        ("dsnu", "read-noise", [capture("dark", "dark", BLACK_DN, 1)], "dark"),
        ("tone-curve", "exposure-error", [SCENE], "bracket"),
        ("black-level", "veiling-glare", [SCENE], "dark"),
        ("nonlinearity", "exposure-error", [EDGE], "bracket"),
        ("nonlinearity", "tone-curve", [EDGE], "bracket"),
        ("defocus", "lens-blur", [EDGE], "edge"),
        ("motion-blur", "defocus", [EDGE], "edge"),
        ("motion-blur", "lens-blur", [EDGE], "edge"),
        ("rolling-shutter", "pose-error", [moving((100, 0))], "sequence"),
        ("focal-length-error", "pose-error", [board("one")], "board"),
        ("lens-distortion", "pose-error", [board("one")], "board"),
    ],
)
def test_what_looks_alike_is_a_set(effect, other, captures, wanted):
    for one, another in ((effect, other), (other, effect)):
        found = confused_with(one, EFFECTS, captures)
        assert found[another].kind == wanted


@pytest.mark.parametrize(
    ("effect", "other", "captures"),
    [
        ("vignetting", "illumination-gradient", [flat(frames=4)]),
        ("dsnu", "read-noise", [capture("dark", "dark", BLACK_DN, 2)]),
        ("tone-curve", "exposure-error", [SCENE, capture("bracket", "bracket", BLACK_DN + 50)]),
        ("nonlinearity", "tone-curve", [EDGE, capture("bracket", "bracket", BLACK_DN + 50)]),
        ("black-level", "veiling-glare", [SCENE, capture("dark", "dark", BLACK_DN)]),
        ("motion-blur", "defocus", [EDGE, SCENE]),
        ("rolling-shutter", "pose-error", [moving((100, 0)), moving((50, 0))]),
        ("lens-distortion", "pose-error", [board("one"), board("two")]),
    ],
)
def test_the_capture_that_splits_them_ends_the_set(effect, other, captures):
    assert other not in confused_with(effect, EFFECTS, captures)
    assert effect not in confused_with(other, EFFECTS, captures)


@pytest.fixture(scope="module")
def effects():
    return Plugins.discover()


def term(effects: Plugins, name: str, **values: float) -> HypothesisTerm:
    return HypothesisTerm(name, effects.resolve(f"effect.{name}"), values, dict.fromkeys(values, 0.1))


def test_the_next_capture_is_the_one_on_which_rivals_differ(effects):
    glare, offset = term(effects, "veiling-glare", share=0.03), term(effects, "black-level", offset_dn=3.0)
    wanted = best_capture([flat()], [(glare,), (offset,)], seed=1)
    assert wanted is not None
    assert wanted.kind == "dark"


def test_what_moves_pixels_asks_for_a_board(effects):
    lens, length = term(effects, "lens-distortion", k1=-0.2), term(effects, "focal-length-error", scale=1.01)
    through = lens.placed()
    assert through is not None
    assert source_of(through, bench()[0].geometry) is not None
    wanted = best_capture(bench(), [(lens,), (length,)], seed=1)
    assert wanted is not None
    assert wanted.kind == "board"


def test_what_all_explanations_hold_asks_for_nothing(effects):
    """Boards that show a distortion are there; only blur and focus are still to be told apart."""
    lens = term(effects, "lens-distortion", k1=-0.2)
    blur, focus = term(effects, "lens-blur", sigma_px=1.3), term(effects, "defocus", radius_px=2.3)
    wanted = best_capture(bench(), [(lens, blur), (lens, focus)], seed=1)
    assert wanted is not None
    assert wanted.kind != "board"


@pytest.mark.parametrize(
    ("unexplained", "kind"),
    [
        ("displacement", "board"),
        ("row_noise", "dark"),
        ("level", "bracket"),
        ("detail", "edge"),
        (None, "dark"),
    ],
)
def test_what_nothing_explains_asks_for_the_kind_that_shows_it_alone(unexplained, kind):
    wanted = best_capture([flat()], [()], 1, unexplained)
    assert wanted is not None
    assert wanted.kind == kind


def test_blemishes_ask_for_the_same_field_stopped_down():
    wanted = best_capture([flat()], [()], seed=1, unexplained="blemishes")
    assert wanted is not None
    assert wanted.kind == "flat"
    assert "smallest aperture" in wanted.why


def test_only_statistics_that_there_are_ask_for_a_kind():
    for names in _SHOWN_BY.values():
        assert set(names) <= set(_VIEWS)


def test_with_nothing_to_choose_between_the_kind_that_is_missing_is_asked_for(effects):
    wanted = best_capture([SCENE], [()], seed=1)
    assert wanted is not None
    assert wanted.kind == "flat"
