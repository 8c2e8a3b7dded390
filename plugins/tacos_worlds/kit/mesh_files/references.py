"""Files and pictures that a file of triangles names: whole, not too large, and not from elsewhere."""

from __future__ import annotations

import binascii
from base64 import b64decode
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, unquote_to_bytes, urlsplit

from PIL.Image import Image

from tacos_files.images import checked_header, decode_picture
from tacos_framework import Fault, UserError
from tacos_framework.files import MB, decoded, limits, named_file, read_bytes, too_large
from tacos_worlds.kit.mesh_files.packed import is_ktx2, ktx2_bytes, ktx2_picture

_TEXTURES_MB = 800
"""Decoded samples of all pictures of one file together [MB]: 50 of 2048 x 2048 pixels."""


class References:
    """Gives the files that a file names, and keeps what is wrong with them and what is to be said.

    - `path`: the file that names others, whose names start from its folder.
    - `within`: the folder they must lie in.
    - `where`: what names the file in messages.
    - `size_bytes`: its own size, which counts towards that of all.
    """

    def __init__(self, path: Path, within: Path, where: str, size_bytes: int):
        self.file_name = path.name
        self.where = where
        self.faults: list[Fault] = []
        self._folder, self._within = path.parent, within
        self._bytes, self._decoded_bytes = size_bytes, 0
        self.notes: list[str] = []

    def has(self, name: str) -> bool:
        """True if a file of that name is there."""
        try:
            return self._found(name) is not None
        except (OSError, ValueError):  # too long, or with a NUL
            return False

    def lacks(self, name: str, effect: str, *, quoted: bool = False) -> bool:
        """True if a file that a model can do without is nowhere; that is noted, with its effect.

        - `quoted`: whether the name is written as in a URI.
        """
        if name.startswith("data:") or (quoted and _is_elsewhere(name)):
            return False
        file = self._unquoted(name)
        try:
            missing = self._found(file) is None
        except (OSError, ValueError):  # too long, or with a NUL: `bytes_of` says so
            return False
        if missing:
            self.notes.append(f"refers to {file!r}, which is not there: {effect}")
        return missing

    def from_library(self, library: str, name: str) -> str:
        """A name from the model's folder, of a file that a library of materials may name from its own."""
        near = str(PurePosixPath(library.replace("\\", "/")).parent / name.replace("\\", "/"))
        try:
            return near if any(self._named(self._folder / each) for each in (near, unquote(near))) else name
        except (OSError, ValueError):  # too long, or with a NUL: `bytes_of` says so
            return name

    def bytes_of(self, name: str, *, quoted: bool = False) -> bytes:
        """The bytes that a name or a data URI stands for.

        - `quoted`: whether the name is written as in a URI.
        """
        try:
            content = self._data(name) if name.startswith("data:") else self._file(name, quoted)
            self._bytes += len(content)
            if self._bytes > limits().bytes_of("mesh_mb"):
                raise UserError(too_large(self.where, "the file with all it names", self._bytes, "mesh_mb"))
        except UserError as error:
            self.faults.extend(error.faults)
            raise
        return content

    def text_of(self, content: bytes, what: str) -> str:
        """Text of a file; older programs write names in Windows-1252, which is noted."""
        text, error = decoded(content)
        if "\0" in text:
            raise UserError(Fault(self.where, "is no text", what, "Export the model again."))
        if error is not None:
            self.notes.append("names are not in UTF-8, and are read as Windows-1252")
        return text

    def picture(self, content: bytes, name: str) -> Image:
        """A picture, which is whole and decodes; the fault of one that does not is kept and raised."""
        try:
            header = None if is_ktx2(content) else checked_header(content, self.where, name, of_texture=True)
            self._decoded_bytes += header.decoded_bytes if header else ktx2_bytes(content)
            if self._decoded_bytes > _TEXTURES_MB * MB:
                what = f"its pictures take {self._decoded_bytes / MB:.0f} MB"
                raise UserError(
                    Fault(self.where, what, f"at most {_TEXTURES_MB}", "Make the pictures smaller.")
                )
            decode = decode_picture if header else ktx2_picture
            return decode(content, self.where, name)
        except UserError as error:
            self.faults.extend(error.faults)
            raise

    def refuse_faults(self) -> None:
        """Raise what was found wrong until now, if anything."""
        if self.faults:
            raise UserError(dict.fromkeys(self.faults))

    def _data(self, uri: str) -> bytes:
        head, _, data = uri.partition(",")
        try:
            plain = unquote_to_bytes(data)
            return b64decode(b"".join(plain.split()), validate=True) if head.endswith(";base64") else plain
        except (binascii.Error, ValueError) as error:
            raise UserError(Fault(self.where, f"holds data that cannot be read: {error}")) from error

    def _file(self, name: str, quoted: bool) -> bytes:
        file = self._unquoted(name)
        if quoted and _is_elsewhere(name):
            what = f"refers to {name[:80]!r}, on another machine"
            raise UserError(Fault(self.where, what, "files beside it", "Copy that file beside the model."))
        try:
            target = self._found(file)
            asked = self._folder / file.replace("\\", "/")
            inside = (target or asked).resolve().is_relative_to(self._within.resolve())
        except (OSError, ValueError) as error:  # a name too long, or with a NUL
            raise UserError(
                Fault(self.where, f"refers to {file[:80]!r}, which is no name: {error}")
            ) from error
        remedy = "Copy that file beside the model."
        if not inside:
            what = f"refers to {file!r}, outside of {self._within}"
            raise UserError(Fault(self.where, what, "files in that folder", remedy))
        if target is None:
            raise UserError(Fault(self.where, f"refers to {file!r}, which does not exist", "", remedy))
        if target.name.casefold() != file.casefold() and target.parent != asked.parent:
            self.notes.append(f"refers to {file!r}: {target.name} beside it is read")
        return read_bytes(target, "mesh_mb", where=self.where, within=self._within)

    def _unquoted(self, name: str) -> str:
        """A name without the escapes of URIs, which programs write into other files too."""
        return name if self.has(name) else unquote(name)

    def _found(self, file: str) -> Path | None:
        """The file of a name: as it stands, in other capitals, or beside the model.

        Models come from machines that do not tell capitals apart, or with paths that hold there alone. One
        outside of the folder that files must lie in comes last: it is refused.
        """
        place = self._folder / PurePosixPath(file.replace("\\", "/"))
        return (
            self._named(place)
            or self._named(self._folder / place.name)
            or (place if place.exists() else None)
        )

    def _named(self, place: Path) -> Path | None:
        """The file of a place in the folder that files must lie in, in these capitals or others."""
        folder = place.parent
        if not folder.is_dir() or not folder.resolve().is_relative_to(self._within.resolve()):
            return None
        return named_file(folder, place.name)


def _is_elsewhere(uri: str) -> bool:
    """True if a URI is that of another machine."""
    parts = urlsplit(uri)
    return len(parts.scheme) > 1 or bool(parts.netloc)  # a scheme of one letter is a drive of Windows
