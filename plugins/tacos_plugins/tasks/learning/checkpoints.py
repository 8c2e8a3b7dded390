"""Weights from files of others, safely: nothing in a file is ever executed."""

from __future__ import annotations

import pickle
import struct
import warnings
import zipfile
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load
from torch import Tensor, nn

from tacos_framework import Fault, UserError, did_you_mean, shipped_folder
from tacos_framework.files import read_bytes
from tacos_plugins.tasks.learning.states import MODEL

NONE = "none"
"""Value of a setting ``weights`` for random ones."""
SUFFIXES = (".safetensors", ".pth", ".pt", ".tar")
"""Ending of the names of checkpoints."""
EXPECTED = "a checkpoint of torch (.pth, .pt, .tar) or safetensors, holding named tensors"
UNREADABLE = (
    RuntimeError,
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    AssertionError,
    EOFError,
    OSError,
    ImportError,
    MemoryError,
    OverflowError,
    struct.error,
    zipfile.BadZipFile,
)
"""Errors of torch's loader on damaged files."""
_ZIP = b"PK\x03\x04"
SHOWN = 3
"""Names listed of each kind of mismatch."""


def named_weights(name: str, *, where: str, others: Sequence[str] = ()) -> Path | None:
    """The file a setting ``weights`` names: by its path, or as weights that are shipped; None for ``none``.

    `others`: what else the setting may say, for the message.

    Raises `UserError` when there is no such file, or it begins as no checkpoint does.
    """
    if name == NONE:
        return None
    path = Path(name)
    if path.suffix in SUFFIXES:
        if not path.is_file():
            raise UserError(
                Fault(
                    where,
                    f"there is no file {path}",
                    EXPECTED,
                    "Correct the path, or make it: procedure.pretrain does.",
                )
            )
        _refuse_other_kinds(path, where)
        return path
    shipped = {path.stem: path for path in (shipped_folder("catalogs") / "weights").glob("*.safetensors")}
    if name not in shipped:
        words = ", ".join((NONE, *others))
        expected = f"{words}, a file ({', '.join(SUFFIXES)}), or the name of shipped weights"
        raise UserError(
            Fault(where, f"no weights {name!r} are shipped", expected, did_you_mean(name, shipped))
        )
    return shipped[name]


def _refuse_other_kinds(path: Path, where: str) -> None:
    """Raise where a file begins as a web page, a note or nothing: before anything is rendered."""
    head = read_bytes(path, "weights_mb", where=where)[:9]
    if path.suffix == ".safetensors" and head[8:] != b"{":
        raise _not_one(path, where, "it is no safetensors file")
    if all(9 <= byte < 127 for byte in head):  # text; pickles and archives have other bytes
        raise _not_one(path, where, f"it begins with {head.decode()!r}" if head else "it is empty")


def read_checkpoint(path: Path, *, where: str) -> dict[str, Tensor]:
    """The named tensors of a checkpoint, on the CPU.

    Reads safetensors, those of our own results (``weights/*.safetensors``) included, and what `torch.save`
    wrote, with torch's loader that builds tensors and plain values and refuses all else. A dict that keeps
    them under ``state_dict`` or ``model`` is opened; the prefix ``module.`` of parallel training falls away.

    Raises `UserError` when the file is not there or not such a checkpoint.
    """
    raw = read_bytes(path, "weights_mb", where=where)
    content = _safetensors(raw, path, where) if path.suffix == ".safetensors" else _torch(raw, path, where)
    for key in ("state_dict", "model"):
        if isinstance(content, Mapping) and isinstance(content.get(key), Mapping):
            content = content[key]
    if not isinstance(content, Mapping) or not content:
        raise _not_one(path, where, f"it holds {_described(content)}")
    if strange := [name for name, value in content.items() if not isinstance(value, Tensor)]:
        raise _not_one(path, where, f"its entries are not all tensors: {_listed(map(str, strange))}")
    tensors = {str(name): value for name, value in content.items()}
    if any(name.startswith(MODEL) for name in tensors):  # a state of ours: leave the optimizer's part out
        tensors = {name: value for name, value in tensors.items() if name.startswith(MODEL)}
        return _without(MODEL, tensors)
    return _without("module.", tensors)


def load_checkpoint(tensors: Mapping[str, Tensor], module: nn.Module, *, where: str, made_for: str) -> None:
    """Load named tensors into a module; every entry must be there, in its shape, and none besides.

    Counters of batch normalisation, which old versions of torch did not keep, may be absent.

    `made_for`: what the module is, for the message: ``PSMNet of width 1``.

    Raises `UserError` when the tensors are those of another architecture; names what differs.
    """
    wanted = module.state_dict()
    given = dict(tensors)
    for name, tensor in wanted.items():
        if name.endswith("num_batches_tracked"):
            given[name] = given.get(name, torch.zeros_like(tensor)).reshape(tensor.shape)
    misshapen = [
        f"{name} {tuple(given[name].shape)} instead of {tuple(tensor.shape)}"
        for name, tensor in wanted.items()
        if name in given and given[name].shape != tensor.shape
    ]
    mismatches = {
        "missing": [name for name in wanted if name not in given],
        "unknown": [name for name in given if name not in wanted],
        "of another shape": misshapen,
    }
    if found := [f"{len(names)} {kind} ({_listed(names)})" for kind, names in mismatches.items() if names]:
        raise UserError(
            Fault(
                where,
                f"the weights are not those of this architecture: {'; '.join(found)}",
                f"the {len(wanted)} entries of {made_for}",
                "Name weights of this network, or change its settings to those the weights were made with.",
            )
        )
    module.load_state_dict(given)


def _safetensors(raw: bytes, path: Path, where: str) -> dict[str, Tensor]:
    try:
        return load(raw)
    except (SafetensorError, KeyError, ValueError) as error:
        raise _not_one(path, where, f"it is no safetensors file: {error}") from error


def _torch(raw: bytes, path: Path, where: str) -> Any:
    try:
        if raw.startswith(_ZIP):  # torch itself packs nothing, and unpacks whatever is claimed
            with zipfile.ZipFile(BytesIO(raw)) as archive:
                claimed = sum(member.file_size for member in archive.infolist())
            if claimed > len(raw):
                raise _not_one(path, where, f"it is packed, {len(raw)} bytes for {claimed}")
        with warnings.catch_warnings():  # of a format it may not know; it then reads it, or not
            warnings.simplefilter("ignore", UserWarning)
            return torch.load(BytesIO(raw), map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        reason = "it is damaged, or holds more than tensors and plain values, which is not run"
        raise _not_one(path, where, reason) from error
    except UNREADABLE as error:
        first = str(error).partition("\n")[0]
        raise _not_one(path, where, f"torch cannot read it: {first}") from error


def _not_one(path: Path, where: str, reason: str) -> UserError:
    return UserError(Fault(where, f"{path} is not a checkpoint: {reason}", EXPECTED, "Name another file."))


def _without(prefix: str, tensors: Mapping[str, Tensor]) -> dict[str, Tensor]:
    if all(name.startswith(prefix) for name in tensors):
        return {name.removeprefix(prefix): value for name, value in tensors.items()}
    return dict(tensors)


def _described(content: Any) -> str:
    return "nothing" if isinstance(content, Mapping) else f"a {type(content).__name__}"


def _listed(names: Sequence[str] | Any) -> str:
    names = list(names)
    more = f", and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"{', '.join(names[:SHOWN])}{more}"
