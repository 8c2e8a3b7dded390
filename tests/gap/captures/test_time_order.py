"""Captures stand in the order they were taken, and their times are held against them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_gap.captures import read_captures, write_captures
from tacos_gap.captures.time_order import in_time_order, time_doubts
from tests.gap.captures.folders import describe, faults, flat_folder, noisy, save_frames
from tests.gap.small_captures import capture

ONE = capture("one", "flat", 100.0)


def taken_at(*times):
    return [replace(ONE, id=f"c{i}", taken_s=time) for i, time in enumerate(times)]


def lit(levels, times, expected=100.0, exposure_ms=10.0, **changes):
    """Flats whose real level is given, taken at these times."""
    flats = []
    for i, (level, time) in enumerate(zip(levels, times, strict=True)):
        flat = capture(f"c{i}", "flat", expected, exposure_ms=exposure_ms)
        real = np.full_like(flat.real_dn, level)
        flats.append(replace(flat, real_dn=real, taken_s=time, **changes))
    return flats


def names(captures):
    return [each.id for each in captures]


def test_captures_are_read_in_the_order_they_were_taken(tmp_path):
    entries = []
    for i, time in enumerate([20.0, 0, 7.5]):
        real = save_frames(tmp_path, f"c{i}", noisy(seed=i))
        entries.append({"id": f"c{i}", "kind": "flat", "real": real, "simulated": 100, "taken_s": time})
    folder = read_captures(describe(tmp_path, *entries))
    assert names(folder.captures) == ["c1", "c2", "c0"]
    assert [each.taken_s for each in folder.captures] == [0.0, 7.5, 20.0]
    assert any("c1: it is listed after c0 and was taken 20 s before it" in t for t in folder.limitations)


def test_without_times_the_order_is_that_of_the_file():
    assert names(in_time_order(taken_at(None, None, None))) == ["c0", "c1", "c2"]


def test_what_has_no_time_stays_behind_what_it_is_listed_after():
    assert names(in_time_order(taken_at(None, 9.0, None, 3.0, None))) == ["c0", "c3", "c4", "c1", "c2"]


@given(st.lists(st.none() | st.floats(-1e9, 1e9), max_size=8))
def test_times_never_fall_and_nothing_is_lost(times):
    ordered = in_time_order(taken_at(*times))
    known = [each.taken_s for each in ordered if each.taken_s is not None]
    assert known == sorted(known)
    assert sorted(names(ordered)) == [f"c{i}" for i in range(len(times))]


@pytest.mark.parametrize("time", ["noon", [1, 2], 1e15])
def test_a_time_is_a_number(tmp_path, time):
    assert "taken_s" in " ".join(faults(flat_folder(tmp_path, taken_s=time)))


def test_frames_that_take_longer_than_what_lies_between_them_are_doubted():
    long = [replace(each, exposure_stated=True) for each in lit([100, 100], [0, 1.5], exposure_ms=2000)]
    (said,) = time_doubts(long)
    assert "c1: it was taken 1.5 s after c0" in said
    assert "take 4 s" in said
    assert not list(time_doubts([replace(each, exposure_stated=False) for each in long]))


def test_whole_seconds_are_no_contradiction():
    assert not list(time_doubts(lit([100, 100], [3, 3], exposure_ms=400)))


@pytest.mark.parametrize(("levels", "word"), [((100, 102, 105), "brighter"), ((100, 98, 95), "darker")])
def test_light_that_drifts_is_said(levels, word):
    (said,) = time_doubts(lit(levels, [0, 60, 300]))
    assert f"{word} than c0, 300 s before it" in said
    assert "level_uncertainty" in said


@pytest.mark.parametrize(
    "captures",
    [
        lit((100, 105, 101), [0, 60, 300]),
        lit((100, 105), [0, 60]),
        lit((100, 100.2, 100.4), [0, 60, 300]),
        lit((100, 102, 105), [0, 60, 300], level_uncertainty=0.1),
        lit((100, 102, 105), [None, 60, 300]),
        lit((255, 255, 255), [0, 60, 300]),
    ],
    ids=["up_and_down", "two", "within_a_percent", "as_stated", "untimed", "clipped"],
)
def test_what_is_no_drift_is_not_called_one(captures):
    assert not list(time_doubts(captures))


def test_a_bent_response_is_no_drift_though_levels_rise_with_time():
    rising = [
        replace(lit([level**0.9], [time], expected=level)[0], id=f"c{time}")
        for time, level in enumerate((50.0, 100.0, 180.0))
    ]
    assert not list(time_doubts(rising))


def test_a_time_comes_back(tmp_path):
    real = np.rint(np.random.default_rng(0).normal(100, 3, ONE.real_dn.shape)).astype(np.float32)
    sequence = replace(ONE, kind="sequence", real_dn=real, taken_s=12.5, motion_blurred=True)
    write_captures(tmp_path, [sequence])
    (read,) = read_captures(tmp_path).captures
    assert (read.taken_s, read.motion_blurred) == (12.5, True)
