"""The executor."""

from __future__ import annotations

from tacos_framework.testing import ExecutorConformance

from tacos_example.futures import FuturesExecutor


class TestFuturesExecutor(ExecutorConformance):
    component = FuturesExecutor
