"""Results belong to the job whose key they carry, in whatever order an executor gives them."""

from __future__ import annotations

import random

import pytest

from tacos_framework.errors import ContractBroken
from tacos_framework.plugins import culprit_of
from tacos_framework.plugins.executing import GuardedExecutor


class Unruly:
    """Does all jobs, then hands on what `change` makes of the results."""

    def __init__(self, change):
        self.change, self.kept = change, []

    def map(self, evaluate, jobs):
        results = [evaluate(job) for job in jobs]
        self.kept.append(results)
        yield from self.change(results)

    def close(self):
        raise OSError("the line is dead")


def shuffled(results):
    return random.Random(3).sample(results, len(results))


def squares(change, count=4):
    executor = GuardedExecutor(Unruly(change), "executor.acme", "acme-clusters")
    return list(executor.map(lambda job: job * job, range(count)))


@pytest.mark.parametrize("change", [shuffled, lambda results: results[::-1], lambda results: results])
def test_the_order_is_put_right(change):
    assert squares(change) == [0, 1, 4, 9]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda results: results[:-1], "gives no result for 1 of 4 jobs: 4"),
        (lambda results: results[2:], "gives no result for 2 of 4 jobs: 1, 2"),
        (lambda results: [], "gives no result for 4 of 4 jobs: 1, 2, 3, 4"),
        (lambda results: [*results, results[0]], "gives the result of job 1 of 4 twice"),
        (lambda results: [results[1], results[1]], "gives the result of job 2 of 4 twice"),
        (lambda results: [16, *results], "gives 16 where the result of a job is expected"),
    ],
)
def test_results_that_fit_no_job_are_errors_that_name_the_executor(change, said):
    with pytest.raises(ContractBroken, match=f"^executor.acme of acme-clusters {said}") as raised:
        squares(change)
    assert culprit_of(raised.value).use == "executor.acme"


def test_results_of_an_earlier_call_are_not_taken_for_those_of_this_one():
    unruly = Unruly(lambda results: unruly.kept[0])
    executor = GuardedExecutor(unruly)
    assert list(executor.map(abs, [-1, -2])) == [1, 2]
    with pytest.raises(ContractBroken, match="the executor Unruly gives a result that belongs to none"):
        list(executor.map(abs, [-3, -4]))


def test_no_results_at_all_are_said_to_be_none():
    class Silent(Unruly):
        def map(self, evaluate, jobs):
            return None

    with pytest.raises(ContractBroken, match="gives None where results are expected, one a job"):
        list(GuardedExecutor(Silent(None)).map(abs, [1]))


def test_results_come_as_soon_as_they_and_those_before_them_are_there():
    done = []
    executor = GuardedExecutor(Lazy())
    results = executor.map(lambda job: done.append(job) or job, range(3))
    assert (next(results), done) == (0, [0])


class Lazy(Unruly):
    def __init__(self):
        """Nothing is kept."""

    def map(self, evaluate, jobs):
        return map(evaluate, jobs)


def test_what_a_job_raises_is_not_blamed_on_the_executor():
    with pytest.raises(ZeroDivisionError) as raised:
        list(GuardedExecutor(Lazy()).map(lambda job: 1 / job, [0]))
    assert culprit_of(raised.value) is None


def test_what_the_executor_raises_is():
    with pytest.raises(OSError, match="the line is dead") as raised:
        GuardedExecutor(Unruly(None), "executor.acme", "acme-clusters").close()
    assert raised.value.__notes__ == ["in executor.acme of acme-clusters"]


def test_a_lost_job_is_answered_as_before():
    class Losing(Unruly):
        def map(self, evaluate, jobs):
            lost = getattr(evaluate, "lost", None)
            return (lost(job, "it died") for job in jobs) if lost else iter(["nothing"])

    class Evaluate:
        def __call__(self, job):
            return job

        def lost(self, job, reason):
            return f"{job}: {reason}"

    assert list(GuardedExecutor(Losing(None)).map(Evaluate(), ["a", "b"])) == ["a: it died", "b: it died"]
    with pytest.raises(ContractBroken, match="gives 'nothing'"):
        list(GuardedExecutor(Losing(None)).map(abs, [1]))
