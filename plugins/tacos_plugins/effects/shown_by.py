"""Captures that the default effects need, in the words of a remedy."""

from __future__ import annotations

from tacos_framework import ShownBy
from tacos_plugins.effects.observations import (
    FEWEST_TIMES,
    FEWEST_VIEWS,
    a_series_of_exposures,
    any_of_kind,
    colours_or_mono,
    edges_or_known_motion,
    fall_off_expected,
    known_motion,
    levels_expected,
    places_expected,
    repeated,
    structured_of_kind,
    two_dark_exposures,
    two_gains,
    views_of_a_board,
)
from tacos_plugins.effects.settling import FEWEST_FRAMES, a_drift_could_show

DARK = ShownBy(any_of_kind("dark"), "kind dark: frames with the cap on")
DARKS_OF_TWO_TIMES = ShownBy(two_dark_exposures, "kind dark at a second, ten times longer exposure")
TWO_GAINS = ShownBy(two_gains, "kind dark or flat at two gains (gain_db) or more")
EVEN_FIELD = ShownBy(any_of_kind("dark", "flat", "bracket"), "kind dark or flat: an even field")
FLAT = ShownBy(any_of_kind("flat", "bracket"), "kind flat: frames of an even surface")
FALL_OFF = ShownBy(fall_off_expected, "kind flat: frames of an even surface")
REPEATED_FLAT = ShownBy(
    repeated("dark", "flat", "bracket"), "two or more frames of a flat, with the same settings"
)
BRACKET = ShownBy(
    a_series_of_exposures,
    f"kind bracket: {FEWEST_TIMES} or more exposure times under the same light, in one group",
)
EDGES = ShownBy(structured_of_kind("edge", "scene", "chart"), "kind edge: sharp edges all over the field")
LEVELS = ShownBy(levels_expected, "kind flat, chart or scene with `simulated`: light of a known level")
PLACES = ShownBy(places_expected, "kind board, or scene with `simulated`: things of a known place")
EDGES_OR_MOTION = ShownBy(
    edges_or_known_motion,
    "kind edge: print or a photograph on the wall, with edges in all directions; or kind sequence",
)
BOARDS = ShownBy(
    views_of_a_board,
    f"kind board: {FEWEST_VIEWS} or more views, tilted by 20 to 40 degrees to different sides",
)
COLOURS = ShownBy(colours_or_mono, "kind chart: a colour chart with its patches")
MOTION = ShownBy(known_motion, "kind sequence: something that moves at a known velocity_px_s")
SEQUENCE = ShownBy(a_drift_could_show, f"kind sequence: {FEWEST_FRAMES} or more frames in a row")
LAMPS = ShownBy(repeated("flat", "sequence"), "two or more frames under the lamps in question")
