"""One entry of the store: plain data and arrays in a file that shows whether it is whole.

A file is the BLAKE2b digest of what follows (32 bytes), and then a file of safetensors: the arrays by number,
and the plain data as JSON in bytes.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

DIGEST_BYTES = 32
_PLAIN = "plain"


class Damaged(Exception):
    """A file is not as it was written."""


def packed(plain: Any, arrays: Sequence[NDArray[Any]]) -> bytes:
    from safetensors.numpy import save

    text = np.frombuffer(json.dumps(plain).encode(), np.uint8)
    tensors = {str(number): np.atleast_1d(array) for number, array in enumerate(arrays)}
    shapes = np.frombuffer(json.dumps([array.shape for array in arrays]).encode(), np.uint8)
    content = save({_PLAIN: text, "shapes": shapes, **tensors})
    return blake2b(content, digest_size=DIGEST_BYTES).digest() + content


def unpacked(data: bytes) -> tuple[Any, list[NDArray[Any]]]:
    """The plain data and the arrays, read-only, of the content of a file.

    Raises `Damaged` when it is not what `packed` gave.
    """
    from safetensors.numpy import load

    content = data[DIGEST_BYTES:]
    if blake2b(content, digest_size=DIGEST_BYTES).digest() != data[:DIGEST_BYTES]:
        raise Damaged(f"its checksum does not fit its {len(data)} bytes")
    tensors = load(content)
    plain = json.loads(tensors.pop(_PLAIN).tobytes())
    shapes = json.loads(tensors.pop("shapes").tobytes())
    arrays = [tensors[str(number)].reshape(shape) for number, shape in enumerate(shapes)]
    for array in arrays:
        array.flags.writeable = False
    return plain, arrays


def write_whole(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, whoever else writes it at this moment.

    Raises `OSError` when it cannot be written; nothing of it is left then.
    """
    partial = path.with_name(f"{path.stem}.{os.getpid()}.partial")
    try:
        partial.write_bytes(data)
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)
        raise
