"""Who does which job: every worker works, and goes on with what it has at hand."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tacos_plugins.executors.affinity import JobTimes, assigned
from tacos_plugins.executors.process import ProcessExecutor
from tests.executors import jobs

worlds = st.sampled_from([None, *"abcd"])
at_hand = st.sets(worlds, max_size=2)


@given(waiting=st.lists(worlds, max_size=6), idle=st.lists(at_hand, max_size=3), busy=at_hand)
def test_no_worker_idles_while_a_job_waits_and_no_job_is_given_twice(waiting, idle, busy):
    given_out = assigned(waiting, idle, busy)
    assert len(given_out) == min(len(waiting), len(idle))
    assert len(set(given_out.values())) == len(given_out)
    assert all(0 <= job < len(waiting) for job in given_out.values())


@given(waiting=st.lists(worlds, max_size=6), idle=st.lists(at_hand, max_size=3), busy=at_hand)
def test_a_world_is_made_twice_only_where_a_worker_would_idle(waiting, idle, busy):
    given_out = assigned(waiting, idle, busy)
    made_already = {*busy, *(world for has in idle for world in has)}
    for worker, job in given_out.items():
        if waiting[job] is None or waiting[job] in idle[worker] or waiting[job] not in made_already:
            continue
        left = [world for other, world in enumerate(waiting) if other not in given_out.values()]
        assert not (set(left) - {None}) & idle[worker], "it had something else at hand"
        taken = {*made_already, *(waiting[other] for other in given_out.values())}
        assert all(world in taken for world in left if world is not None), "a new world waits"


def test_what_another_has_is_made_anew_only_where_that_is_sooner():
    waiting = ["attic"] * 4
    assert assigned(waiting, [set()], busy={"attic"}, cost_of_making=5) == {}
    assert assigned(waiting, [set(), set()], busy={"attic"}, cost_of_making=4) == {0: 3}
    assert assigned([*waiting, "cellar"], [set()], busy={"attic"}, cost_of_making=5) == {0: 4}
    assert assigned(waiting, [{"attic"}], busy={"attic"}, cost_of_making=5) == {0: 0}


def test_two_jobs_of_one_world_are_done_side_by_side_where_the_first_has_just_begun():
    # One after the other takes two jobs' time; to read what the other has, and do one, takes 1.8.
    assert assigned(["attic"] * 2, [{"attic"}, set()], busy=set(), cost_of_making=1.8) == {0: 0, 1: 1}
    assert assigned(["attic"] * 2, [{"attic"}, set()], busy=set(), cost_of_making=2.1) == {0: 0}
    # One that is at it since longer may be done before that.
    assert assigned(["attic"], [set()], busy={"attic"}, cost_of_making=1.8) == {}


def test_the_cost_of_making_is_what_was_seen():
    times = JobTimes()
    assert times.cost_of_making == 1
    times.saw(40.0, made="first")
    times.saw(2.0, made="nothing")
    times.saw(4.0, made="nothing")
    assert times.cost_of_making == 1  # what another has made may be kept where all can read it
    for seconds in (40.0, 12.0, 15.0):  # the first waited for another worker, which was still making it
        times.saw(seconds, made="again")
    assert times.cost_of_making == pytest.approx(4)
    for _ in range(8):  # jobs may grow: the latest tell what the next one takes
        times.saw(8.0, made="nothing")
    assert times.cost_of_making == pytest.approx(1.5)


@pytest.mark.parametrize("scenes", [2, 5, 9])
def test_many_cameras_on_many_scenes_make_each_world_once(scenes):
    cameras, workers = 6, 2
    waiting = [f"world {scene}" for _ in range(cameras) for scene in range(scenes)]
    has: list[set[str | None]] = [set() for _ in range(workers)]
    made: Counter[str] = Counter()
    while waiting:  # jobs of equal length: both workers become idle at the same time
        given_out = assigned(waiting, has, set())
        for worker, job in given_out.items():
            made[waiting[job]] += waiting[job] not in has[worker]
            has[worker].add(waiting[job])
        waiting = [world for job, world in enumerate(waiting) if job not in given_out.values()]
    assert sum(made.values()) <= scenes + (scenes % workers)  # the last of an odd number is shared


def test_a_worker_is_given_what_it_has_at_hand():
    executor = ProcessExecutor(ProcessExecutor.Config(workers=2))
    both = [jobs.Visit("a"), jobs.Visit("b")] * 4
    visitors: dict[str, set[int]] = {"a": set(), "b": set()}
    for visit, process in zip(both, executor.map(jobs.process_id_later, both), strict=True):
        visitors[visit.affinity].add(process)
    for visit in both:
        assert next(executor.map(jobs.process_id_later, [visit])) in visitors[visit.affinity]
    executor.close()
