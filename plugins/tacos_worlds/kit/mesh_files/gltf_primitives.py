"""The corners of a primitive of glTF: stored plainly, packed by Draco, shaped by morph targets and bones."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tacos_worlds.kit.mesh_files.damage import Damaged
from tacos_worlds.kit.mesh_files.gltf_buffers import Buffers, Json
from tacos_worlds.kit.mesh_files.gltf_notes import DRACO, remedy_for


class Primitive:
    def __init__(self, buffers: Buffers, entry: Json) -> None:
        self._buffers, self._entry = buffers, entry
        self.attributes: Json = entry.get("attributes", {})
        packed = entry.get("extensions", {}).get(DRACO)
        position = self.attributes.get("POSITION")
        self._packed = packed if packed and not (position is None or buffers.has_data(position)) else None

    def read(self, name: str) -> NDArray[Any]:
        """(N, width) an attribute, as `Buffers.accessor` gives it."""
        if self._packed is None or name not in self._packed.get("attributes", {}):
            return self._buffers.accessor(self.attributes[name])
        found = self._unpacked.get_attribute_by_unique_id(int(self._packed["attributes"][name]))
        accessor = self._buffers.entry("accessors", self.attributes[name])
        if found is None or len(found["data"]) != accessor.get("count"):
            raise Damaged(f"its Draco data lacks {name}, or has another number of vertices than it says")
        values = np.asarray(found["data"])
        if accessor.get("normalized") and values.dtype.kind in "iu":
            return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)
        return values

    def indices(self, count: int) -> NDArray[np.int64]:
        """Vertices in the order of the primitive, of `count` in all."""
        if self._packed is not None:
            return np.asarray(self._unpacked.faces, np.int64).reshape(-1)
        if "indices" not in self._entry:
            return np.arange(count)
        return self._buffers.accessor(self._entry["indices"])[:, 0].astype(np.int64)

    @cached_property
    def _unpacked(self) -> Any:
        """What DracoPy makes of the primitive."""
        assert self._packed is not None
        try:
            import DracoPy
        except ImportError as error:
            raise Damaged(f"it is compressed by {DRACO}: {remedy_for(DRACO)}") from error
        try:
            return DracoPy.decode(bytes(self._buffers.view(self._packed.get("bufferView"))))
        except DracoPy.FileTypeException as error:
            raise Damaged(f"its Draco data cannot be unpacked: {error}") from error

    def morphed(self, vertices: NDArray[np.float64], weights: Sequence[float]) -> NDArray[np.float64]:
        """The vertices with those of morph targets added, each by its weight."""
        for target, weight in zip(self._entry.get("targets", []), weights, strict=False):
            if weight and "POSITION" in target:
                vertices = vertices + float(weight) * self._buffers.accessor(target["POSITION"])[:, :3]
        return vertices

    def blends(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 4, 4) the transform of each vertex, of those of (J, 4, 4) bones by its weights."""
        total = np.zeros((0, 4, 4))
        for number in range(len(self.attributes)):
            if f"JOINTS_{number}" not in self.attributes:
                break
            bones, weights = self.read(f"JOINTS_{number}"), self.read(f"WEIGHTS_{number}")
            if len(bones) and int(bones.max()) >= len(joints):
                raise Damaged(f"a vertex names bone {int(bones.max())} of {len(joints)}")
            part = np.einsum("nk,nkij->nij", weights.astype(np.float64), joints[bones.astype(np.int64)])
            total = total + part if len(total) else part
        return total / np.maximum(total[:, 3:, 3:], 1e-12)
