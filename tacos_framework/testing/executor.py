"""Conformance suite of executors."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any, ClassVar

import pytest

from tacos_framework.errors import CandidateFailed, Fault, UserError
from tacos_framework.testing.component import ComponentConformance


def halve(job: int) -> float:
    """A job that takes the longer the earlier it stands, so that order is not a matter of luck."""
    time.sleep(0.02 * (4 - job % 5))
    return job / 2


def refuse_three(job: int) -> int:
    """A job that fails at 3."""
    if job == 3:
        error = CandidateFailed("three is too many")
        error.add_note("in a test")
        raise error
    return job


def refuse_all(job: int) -> int:
    """A job that is the user's mistake, twice."""
    raise UserError([Fault("recipe.yaml:1:1", f"{job} is wrong"), Fault("recipe.yaml:2:1", "this too")])


class ExecutorConformance(ComponentConformance):
    """The suite for executors."""

    kind: ClassVar[str] = "executor"

    @pytest.fixture(scope="class")
    @classmethod
    def executor(cls) -> Iterator[Any]:
        """One executor for all tests."""
        executor = cls().make()
        yield executor
        executor.close()

    def test_results_are_those_of_plain_calls_in_order(self, executor: Any) -> None:
        assert list(executor.map(halve, range(7))) == [halve(job) for job in range(7)]

    def test_no_jobs_give_no_results(self, executor: Any) -> None:
        assert list(executor.map(halve, [])) == []

    def test_results_before_an_error_arrive_and_the_error_is_unchanged(self, executor: Any) -> None:
        results = executor.map(refuse_three, range(5))
        assert [next(results) for _ in range(3)] == [0, 1, 2]
        with pytest.raises(CandidateFailed, match="three is too many") as raised:
            next(results)
        assert raised.value.__notes__ == ["in a test"]

    def test_errors_keep_what_they_carry(self, executor: Any) -> None:
        with pytest.raises(UserError) as raised:
            list(executor.map(refuse_all, [7]))
        assert [fault.what for fault in raised.value.faults] == ["7 is wrong", "this too"]

    def test_functions_may_change_between_calls(self, executor: Any) -> None:
        assert list(executor.map(halve, [1, 2])) == [0.5, 1.0]
        assert list(executor.map(refuse_three, [1, 2])) == [1, 2]

    def test_it_works_on_after_an_error(self, executor: Any) -> None:
        with pytest.raises(CandidateFailed):
            list(executor.map(refuse_three, [3]))
        assert list(executor.map(refuse_three, [4])) == [4]

    def test_results_may_be_left_behind(self, executor: Any) -> None:
        assert next(iter(executor.map(halve, range(5)))) == 0
        assert list(executor.map(halve, [2])) == [1.0]

    def test_closing_twice_is_safe(self) -> None:
        executor = self.make()
        list(executor.map(halve, [1]))
        executor.close()
        executor.close()
