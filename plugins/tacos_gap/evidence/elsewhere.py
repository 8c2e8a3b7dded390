"""Evidence in other processes: each measures and simulates captures of its own while the others do.

Threads would take turns, since a simulation is made of many short steps of the interpreter.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import weakref
from collections.abc import Callable, Mapping, Sequence
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from operator import attrgetter, methodcaller
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from tacos_framework import Fault, UserError
from tacos_framework.formation import PlacedEffect
from tacos_gap.captures import RealCapture
from tacos_gap.evidence.contract import Evidence, Label, PictureEvidence, ReplicateResiduals
from tacos_gap.evidence.keeper import Job, Keeper, Kept
from tacos_plugins.executors.outcomes import WorkerTraceback
from tacos_plugins.executors.worker import Answer
from tacos_plugins.executors.worker_process import ending_in_words

Result = TypeVar("Result")

# The path is set first: what this process imports may come from where no other would look.
_PROGRAM = """
import sys
from multiprocessing.connection import Connection

channel = Connection(int(sys.argv[1]))
sys.path[:] = channel.recv()
from tacos_gap.evidence.keeper import serve

serve(channel)
"""


def of_each(function: Callable[[Any], Result], evidence: Sequence[Evidence]) -> list[Result]:
    """What a function makes of each, where it is; processes work at the same time.

    - `function`: can be pickled where evidence is elsewhere, as a `partial` of a function of a module.
    """
    places = [each.process if isinstance(each, EvidenceElsewhere) else None for each in evidence]
    things = [each.number if isinstance(each, EvidenceElsewhere) else each for each in evidence]
    made = _applied(function, things, places)
    return [_at_hand(one, each) for one, each in zip(made, evidence, strict=True)]


def _at_hand(made: Any, evidence: Evidence) -> Any:
    if not isinstance(made, Kept):
        return made
    assert isinstance(evidence, EvidenceElsewhere)
    return evidence if made.number == evidence.number else evidence.follower(made.number)


def measured(
    function: Callable[[RealCapture], PictureEvidence],
    captures: Sequence[RealCapture],
    processes: Sequence[EvidenceProcess],
) -> list[PictureEvidence]:
    """Evidence of captures, spread over this process and others by the size of their frames."""
    places = _spread([capture.real_dn.size for capture in captures], (None, *processes))
    found: list[PictureEvidence] = []
    for made, capture, process in zip(_applied(function, captures, places), captures, places, strict=True):
        if process is not None:
            assert isinstance(made, Kept)
            made = EvidenceElsewhere(process, made.number, capture, made.labels or ())
        found.append(made)
    return found


def _spread(sizes: Sequence[int], places: Sequence[EvidenceProcess | None]) -> list[EvidenceProcess | None]:
    """The place of each: the largest first, each to where least is yet (Graham 1969)."""
    loads = [0] * len(places)
    chosen = [places[0]] * len(sizes)
    for index in sorted(range(len(sizes)), key=lambda index: -sizes[index]):
        least = loads.index(min(loads))
        loads[least] += sizes[index]
        chosen[index] = places[least]
    return chosen


def _applied(
    function: Callable[[Any], Any], things: Sequence[Any], places: Sequence[EvidenceProcess | None]
) -> list[Any]:
    """What a function makes of each thing, in order, in the place of each.

    What it raises leaves as it is, once all places are done with their things.
    """
    members: dict[EvidenceProcess, list[int]] = {}
    for index, place in enumerate(places):
        if place is not None:
            members.setdefault(place, []).append(index)
    for process, indices in members.items():
        process.ask(function, [things[index] for index in indices])
    made: list[Any] = [None] * len(things)
    try:
        for index, place in enumerate(places):
            if place is None:
                made[index] = function(things[index])
    finally:
        answers = {process: process.answer() for process in members}
    for process, answer in answers.items():
        if answer.error is not None:
            raise answer.error from WorkerTraceback(answer.traceback)
        for index, value in zip(members[process], answer.value, strict=True):
            made[index] = value
    return made


class EvidenceProcess:
    """A process that keeps evidence. It ends once nobody holds it any more.

    `payload`: its pickled `Keeper`.
    """

    def __init__(self, payload: bytes) -> None:
        self._channel, theirs = Pipe()
        number = theirs.fileno()
        self._process = subprocess.Popen([sys.executable, "-c", _PROGRAM, str(number)], pass_fds=(number,))
        theirs.close()  # so that the channel breaks when the process dies
        weakref.finalize(self, _end, self._process, self._channel)
        self._forgotten: list[int] = []
        self._send(ForkingPickler.dumps(sys.path))
        self._send(payload)
        self.ask(_nothing, ())

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def ask(self, function: Callable[[Any], Any], things: Sequence[Any]) -> None:
        """Have it apply a function; its `answer` is to be taken before it is asked again."""
        job = Job(function, things, tuple(self._forgotten))
        message = ForkingPickler.dumps(job)
        self._forgotten.clear()
        self._send(message)

    def answer(self) -> Answer:
        """The answer to what was asked last, waited for.

        Raises `UserError` where the process has ended.
        """
        try:
            answer: Answer = self._channel.recv()
        except (EOFError, ConnectionResetError):
            raise _ended(self._process) from None
        return answer

    def forget(self, number: int) -> None:
        self._forgotten.append(number)

    def _send(self, message: bytes | memoryview) -> None:
        try:
            self._channel.send_bytes(message)
        except (BrokenPipeError, ConnectionResetError):
            raise _ended(self._process) from None


def processes_beside(count: int, needed: Sequence[Any]) -> list[EvidenceProcess]:
    """Processes on their way; none where something that is `needed` there cannot travel to them."""
    try:
        payload = bytes(ForkingPickler.dumps(Keeper(needed)))
    except (pickle.PicklingError, AttributeError, TypeError):
        return []
    return [EvidenceProcess(payload) for _ in range(count)]


def ready(processes: Sequence[EvidenceProcess]) -> list[EvidenceProcess]:
    """Those of some new processes that could load what is needed there."""
    return [process for process in processes if process.answer().error is None]


def _nothing(_: Any) -> None:
    """What a process is asked for first, to see whether it starts."""


def _end(process: subprocess.Popen[bytes], channel: Connection) -> None:
    process.kill()
    process.wait()
    channel.close()


def _ended(process: subprocess.Popen[bytes]) -> UserError:
    return UserError(
        Fault(
            "workers",
            f"a process that simulates captures {ending_in_words(process.wait())}",
            "processes that run to the end of the diagnosis",
            "Set workers: 1 to have all captures in one process, and --resume to go on from what was found.",
        )
    )


class EvidenceElsewhere(PictureEvidence):
    """Evidence of a capture that another process keeps.

    `number`: its number there.
    """

    def __init__(
        self, process: EvidenceProcess, number: int, capture: RealCapture, labels: Sequence[Label]
    ) -> None:
        self.process = process
        self.number = number
        self.capture = capture
        self.labels = labels
        weakref.finalize(self, process.forget, number)

    def follower(self, number: int) -> EvidenceElsewhere:
        """The evidence there that was made of this one."""
        return EvidenceElsewhere(self.process, number, self.capture, self.labels)

    def _told(self, function: Callable[[PictureEvidence], Any]) -> Any:
        return of_each(function, [self])[0]

    @property
    def real(self) -> NDArray[np.float64]:
        return np.asarray(self._told(attrgetter("real")))

    @property
    def sigma(self) -> NDArray[np.float64]:
        return np.asarray(self._told(attrgetter("sigma")))

    @property
    def null_replicates(self) -> NDArray[np.float64]:
        return np.asarray(self._told(attrgetter("null_replicates")))

    @property
    def left_out(self) -> list[str]:
        return list(self._told(attrgetter("left_out")))

    def residual(self, effects: Sequence[PlacedEffect], draws: int = 1) -> NDArray[np.float64]:
        return np.asarray(self._told(methodcaller("residual", effects, draws)))

    def replicate_residuals(self, effects: Sequence[PlacedEffect]) -> ReplicateResiduals:
        found: ReplicateResiduals = self._told(methodcaller("replicate_residuals", effects))
        return found

    def nuisances(self, effects: Sequence[PlacedEffect]) -> dict[str, Any]:
        return dict(self._told(methodcaller("nuisances", effects)))

    def pose(self, effects: Sequence[PlacedEffect]) -> dict[str, float] | None:
        found: dict[str, float] | None = self._told(methodcaller("pose", effects))
        return found

    def renuisanced(self, effects: Sequence[PlacedEffect]) -> PictureEvidence:
        found: PictureEvidence = self._told(methodcaller("renuisanced", effects))
        return found

    def agreeing(self, shares: Mapping[str, float]) -> PictureEvidence:
        found: PictureEvidence = self._told(methodcaller("agreeing", shares))
        return found
