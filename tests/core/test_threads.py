"""Linear algebra has one thread while a function runs, and as many as before after it."""

from __future__ import annotations

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from tacos_framework.linear_algebra import in_one_thread


def threads() -> set[int]:
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def _two_threads():
    with threadpool_limits(2, user_api="blas"):
        yield


def test_there_is_one_thread_meanwhile_and_as_many_as_before_afterwards():
    before = threads()
    assert in_one_thread(threads)() == {1}
    assert threads() == before


def test_what_is_raised_passes_and_the_threads_come_back():
    before = threads()

    @in_one_thread
    def failing() -> None:
        raise ValueError("as it was")

    with pytest.raises(ValueError, match=r"^as it was$"):
        failing()
    assert threads() == before


def test_functions_in_one_thread_may_call_one_another():
    assert in_one_thread(lambda: (in_one_thread(threads)(), threads()))() == ({1}, {1})
    assert threads() != {1}


def test_a_function_keeps_its_name_and_arguments():
    @in_one_thread
    def times(a: int, *, b: int) -> int:
        """Product."""
        return a * b

    assert times(2, b=3) == 6
    assert (times.__name__, times.__doc__) == ("times", "Product.")
