"""Faults of files that settings name, before anything is read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tacos_framework import Fault

WORLD = (".glb", ".gltf", ".obj", ".ply", ".stl")
TABLE = (".csv", ".yaml", ".yml")
PANORAMA = (".hdr", ".exr")
_CONVERT = {
    ".blend": "In Blender: File, Export, glTF 2.0.",
    ".fbx": "Import it into Blender and export it as glTF 2.0.",
    ".usd": "Import it into Blender and export it as glTF 2.0.",
    ".usdz": "Import it into Blender and export it as glTF 2.0.",
    ".dae": "Import it into Blender 4 and export it as glTF 2.0.",
    ".png": "A panorama of high dynamic range is .hdr or .exr.",
    ".jpg": "A panorama of high dynamic range is .hdr or .exr.",
}


def faults_of_files(file: str, labels: str, sky: str, path: str) -> Iterator[Fault]:
    for name, value, suffixes in (
        ("file", file, WORLD),
        ("labels", labels, TABLE),
        ("sky", sky, PANORAMA),
        ("path", path, ()),
    ):
        if not value:
            if name == "file":
                yield Fault("scene.imported: file", "is empty", f"a {', '.join(WORLD)} file")
            continue
        where, target = value, Path(value).expanduser()  # whoever gave it knows at which key
        suffix = target.suffix.lower()
        if suffixes and suffix not in suffixes:
            what = f"is no {', '.join(suffixes)} file, which {name} names"
            yield Fault(where, what, remedy=_CONVERT.get(suffix, ""))
        elif not target.is_file():
            what = "is not a regular file" if target.exists() else "does not exist"
            yield Fault(where, f"{what}, which {name} names", remedy="Check the path.")
