"""Random generators spawned by name from one seed, so that no draw depends on what else was drawn."""

from __future__ import annotations

import json
from hashlib import blake2b
from operator import index

import numpy as np


def generator(seed: int, *names: str | int) -> np.random.Generator:
    """The generator that belongs to `names` under `seed`.

    The same seed and names give the same stream in every run, process and platform, whatever
    ``PYTHONHASHSEED`` says; streams of different names are independent.

    `seed`: the study's seed, 0 or above. `names`: what the numbers are for, from the general to the
    particular. The word ``"3"`` and the number 3 are different names.

    The names are hashed (BLAKE2b over their JSON list) into the spawn key of a `numpy.random.SeedSequence`,
    which feeds a PCG64.

    >>> generator(7, "noise", "generation", 3).integers(1000, size=3).tolist()
    [771, 212, 646]
    >>> bool(generator(7, "a").random() == generator(7, "b").random())
    False
    """
    if index(seed) < 0:
        raise ValueError(f"a seed must be 0 or above, not {seed}")
    path = json.dumps([name if isinstance(name, str) else index(name) for name in names])
    digest = blake2b(path.encode(), digest_size=16).digest()
    words = tuple(int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4))
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(index(seed), spawn_key=words)))
