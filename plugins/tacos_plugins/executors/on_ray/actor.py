"""The code inside a Ray worker. Imports little, so that it starts fast."""

from __future__ import annotations

from tacos_plugins.executors.worker import WorkerState


class EvaluatorActor:
    """A process of its own on some node, which holds one function and what that keeps."""

    def __init__(self, payload: bytes, threads: int) -> None:
        import cv2

        cv2.setNumThreads(threads)
        self._state = WorkerState(payload)

    def ready(self) -> None:
        """Answers once the process has started."""

    def answer(self, message: bytes) -> bytes:
        """The pickled `tacos_plugins.executors.worker.Answer` to a pickled job."""
        return self._state.answer(message)
