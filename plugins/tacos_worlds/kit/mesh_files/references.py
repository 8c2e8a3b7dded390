"""Files and pictures that a file of triangles names: whole, not too large, and not from elsewhere."""

from __future__ import annotations

import binascii
from base64 import b64decode
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from PIL.Image import Image
from trimesh.resolvers import Resolver

from tacos_files.images import checked_header, decode_picture
from tacos_framework import Fault, UserError
from tacos_framework.files import MB, limits, read_bytes, too_large
from tacos_worlds.kit.mesh_files.mtl import Library, MtlMaterial

_DATA = "base64,"
_TEXTURES_MB = 800
"""Decoded samples of all pictures of one file together [MB]: 50 of 2048 x 2048 pixels."""


class References(Resolver):
    """Gives trimesh the files that a file names, and keeps what is wrong with them: trimesh drops it.

    Parameters
    ----------
    path
        The file that names others, whose names start from its folder.
    within
        The folder they must lie in.
    where
        What names the file in messages.
    size_bytes
        Its own size, which counts towards that of all.
    """

    def __init__(self, path: Path, within: Path, where: str, size_bytes: int):
        self.file_name = path.name
        self.where = where
        self.faults: list[Fault] = []
        self._folder, self._within = path.parent, within
        self._bytes, self._decoded_bytes = size_bytes, 0
        self._read: dict[str, bytes] = {}
        self.materials: Mapping[str, MtlMaterial] = {}
        self.notes: list[str] = []

    def use_library(self, name: str, library: Library) -> None:
        """Keep what a library of materials says, and give its plain text under that name."""
        self._read[name] = library.plain.encode()
        self.materials = library.materials
        self.notes += library.notes

    def get(self, key: str) -> bytes:
        """The bytes of a file by its name, which is a picture unless it was read before.

        Raises UserError when it is none that may be read; the faults are kept as well.
        """
        if key not in self._read:
            self.picture(self.bytes_of(key), key)
        return self._read[key]

    def bytes_of(self, name: str, *, quoted: bool = False) -> bytes:
        """The bytes that a name or a data URI stands for; those of a name are kept.

        `quoted`: true if the name is written as in a URI.
        """
        try:
            content = self._data(name) if name.startswith("data:") else self._file(name, quoted)
            self._bytes += len(content)
            if self._bytes > limits().bytes_of("mesh_mb"):
                raise UserError(too_large(self.where, "the file with all it names", self._bytes, "mesh_mb"))
        except UserError as error:
            self.faults.extend(error.faults)
            raise
        self._read[name] = content
        return content

    def picture(self, content: bytes, name: str) -> Image:
        """A picture, which is whole and decodes; the fault of one that does not is kept and raised."""
        try:
            self._decoded_bytes += checked_header(content, self.where, name).decoded_bytes
            if self._decoded_bytes > _TEXTURES_MB * MB:
                what = f"its pictures take {self._decoded_bytes / MB:.0f} MB"
                raise UserError(
                    Fault(self.where, what, f"at most {_TEXTURES_MB}", "Make the pictures smaller.")
                )
            return decode_picture(content, self.where, name)
        except UserError as error:
            self.faults.extend(error.faults)
            raise

    def refuse_faults(self) -> None:
        """Raise what was found wrong until now, if anything."""
        if self.faults:
            raise UserError(dict.fromkeys(self.faults))

    def _data(self, uri: str) -> bytes:
        start = uri.find(_DATA)
        try:
            if start < 0:
                raise ValueError("it is not base64")
            return b64decode(uri[start + len(_DATA) :], validate=True)
        except (binascii.Error, ValueError) as error:
            raise UserError(Fault(self.where, f"holds data that cannot be read: {error}")) from error

    def _file(self, name: str, quoted: bool) -> bytes:
        file = unquote(name) if quoted else name
        if quoted and (urlsplit(name).scheme or urlsplit(name).netloc):
            what = f"refers to {name[:80]!r}, on another machine"
            raise UserError(Fault(self.where, what, "files beside it", "Copy that file beside the model."))
        target = self._folder / file.replace("\\", "/")
        remedy = "Copy that file beside the model."
        try:
            inside = target.resolve().is_relative_to(self._within.resolve())
            there = target.exists()
        except (OSError, ValueError) as error:  # a name too long, or with a NUL
            raise UserError(
                Fault(self.where, f"refers to {file[:80]!r}, which is no name: {error}")
            ) from error
        if not inside:
            what = f"refers to {file!r}, outside of {self._within}"
            raise UserError(Fault(self.where, what, "files in that folder", remedy))
        if not there:
            raise UserError(Fault(self.where, f"refers to {file!r}, which does not exist", "", remedy))
        return read_bytes(target, "mesh_mb", where=self.where, within=self._within)

    # What trimesh's interface asks for besides; nothing is ever written, listed or renamed.

    def write(self, name: str, data: Any) -> None:
        """Refused: files are read here."""
        raise NotImplementedError

    def namespaced(self, namespace: str) -> References:
        """Refused: names start from the folder of the file."""
        raise NotImplementedError

    def keys(self) -> list[str]:
        return list(self._read)
