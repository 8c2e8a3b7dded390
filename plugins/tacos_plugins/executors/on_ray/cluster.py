"""The Ray cluster to work on: one that runs, or one of this machine's own for the length of a run."""

from __future__ import annotations

import logging
import math
import os
import socket
import sys
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from tacos_framework import Fault, UserError

log = logging.getLogger(__name__)

LOCAL = "local"
LOOPBACK = "127.0.0.1"
ANSWER_S = 5.0
"""Time for a cluster to accept a connection [s]."""

STORE_BYTES = 256 * 2**20
"""Shared memory for results on their way, in a cluster of our own; what does not fit goes to disk."""

_QUIET = {
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_USAGE_STATS_PROMPT_ENABLED": "0",
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "1",  # said, as Ray warns of another default to come
}
_OWN = {
    "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0",  # listens on the loopback alone, as it does by default there
    "RAY_AUTH_MODE": "token",
    "RAY_OBJECT_STORE_ALLOW_SLOW_STORAGE": "1",
}


@dataclass(frozen=True)
class Needs:
    """Resources of one worker: processors and GPUs, which may be shares of one."""

    cpus: float
    gpus: float

    def __str__(self) -> str:
        gpus = f" and {self.gpus:g} GPU" if self.gpus else ""
        return f"{self.cpus:g} CPU{gpus}"

    def fits_into(self, node: Mapping[str, float]) -> int:
        """Number of workers that a node with these resources holds.

        >>> Needs(cpus=2, gpus=0.5).fits_into({"CPU": 16.0, "GPU": 1.0})
        2
        """
        counts = [math.floor(node.get("CPU", 0.0) / self.cpus + 1e-9)]
        if self.gpus:
            counts.append(math.floor(node.get("GPU", 0.0) / self.gpus + 1e-9))
        return min(counts)


class Cluster:
    """A connection to a cluster, which the process may have had before.

    Raises `UserError` when Ray is not installed, or no cluster answers.

    - `address`: ``local`` starts a cluster on this machine; ``auto`` joins the one that ``ray start`` began
      here or that RAY_ADDRESS names; else ``host:port`` of a running one.
    """

    def __init__(self, address: str, own_cpus: int) -> None:
        self.ray = _ray({**_QUIET, **(_OWN if address == LOCAL else {})})
        self._joined = not self.ray.is_initialized()
        if not self._joined:
            return
        options: dict[str, Any] = {"address": address, "log_to_driver": False, "configure_logging": False}
        if address == LOCAL:
            options |= {
                "num_cpus": own_cpus,
                "include_dashboard": False,
                "_node_ip_address": LOOPBACK,
                "object_store_memory": STORE_BYTES,
            }
        else:
            _refuse_silence(address)
        logging.getLogger("ray").setLevel(logging.ERROR)
        try:
            self.ray.init(**options)
        except (ConnectionError, RuntimeError, ValueError) as error:
            raise UserError(_no_answer(address, str(error))) from error
        if address == LOCAL and (seen_at := self.ray.util.get_node_ip_address()) != LOOPBACK:
            log.warning("ray was imported before, so its cluster here listens on %s too", seen_at)

    def room_for(self, needs: Needs) -> int:
        """Number of workers that all living nodes hold.

        Raises `UserError` when none holds a single one.
        """
        nodes = [node["Resources"] for node in self.ray.nodes() if node["Alive"]]
        room = sum(needs.fits_into(node) for node in nodes)
        if room == 0:
            raise UserError(
                Fault(
                    "executor.ray",
                    f"no node of the cluster has {needs} for a worker",
                    f"the nodes have {_listed(nodes)}",
                    "Lower cpus_per_worker and gpus_per_worker, or add a node.",
                )
            )
        return room

    def leave(self) -> None:
        """Leave the cluster, and end it if it was our own; a connection from before stays."""
        if self._joined:
            self.ray.shutdown()


def _ray(environment: Mapping[str, str]) -> ModuleType:
    """The module, imported with these variables; a host that has it already has made its own choice.

    Ray reads some of them while it is imported and hands all on to what it starts, so that changing them
    later would have its parts disagree.
    """
    if "ray" not in sys.modules:
        for name, value in environment.items():
            os.environ.setdefault(name, value)
    try:
        import ray
    except ModuleNotFoundError as error:
        if error.name != "ray":
            raise
        raise UserError(
            Fault("executor.ray", "the package ray is not installed", "", "pip install tacos-framework[ray]")
        ) from error
    return ray


def _refuse_silence(address: str) -> None:
    """Knock at the door of a cluster: Ray itself would wait for many minutes."""
    named = address if address != "auto" else os.environ.get("RAY_ADDRESS") or _started_here()
    if not named or named == "auto":
        return  # Ray looks for one, and is quick to say that there is none
    host, colon, port = named.rpartition(":")
    if not (colon and port.isdecimal()):
        raise UserError(_no_answer(named, "this is no address", "local, auto, or host:port"))
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=ANSWER_S).close()
    except OSError as error:
        raise UserError(_no_answer(named, str(error))) from error


def _started_here() -> str:
    """The address that ``ray start`` left on this machine; it stays there when the cluster dies."""
    folder = Path(os.environ.get("RAY_TMPDIR") or tempfile.gettempdir())
    try:
        return (folder / "ray" / "ray_current_cluster").read_text(encoding="utf-8").strip()
    except OSError:
        return ""


def _no_answer(address: str, reason: str, expected: str = "") -> Fault:
    return Fault(
        "executor.ray",
        f"no Ray cluster answers at {address!r}: {reason}",
        expected,
        "Start one with 'ray start --head', give the address it prints, or set address: local.",
    )


def _listed(nodes: Iterable[Mapping[str, float]]) -> str:
    return "; ".join(f"{node.get('CPU', 0):g} CPU and {node.get('GPU', 0):g} GPU" for node in nodes) or "gone"
