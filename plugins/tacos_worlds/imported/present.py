"""Faults of files that settings name, before anything is read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tacos_framework import Fault
from tacos_framework.files import CSV_SUFFIXES

WORLD = (".glb", ".gltf", ".obj", ".ply", ".stl")
TABLE = (*CSV_SUFFIXES, ".yaml", ".yml")
PANORAMA = (".hdr", ".exr")
_POINTS = "Make a mesh of the points (Poisson reconstruction in CloudCompare) and export it as PLY."
_CONVERT = {
    ".blend": "In Blender: File, Export, glTF 2.0.",
    **dict.fromkeys(
        (".fbx", ".usd", ".usda", ".usdc", ".usdz", ".abc", ".3ds", ".x3d"),
        "Import it into Blender and export it as glTF 2.0.",
    ),
    ".dae": "Import it into Blender 4 and export it as glTF 2.0.",
    ".ifc": "Convert it by IfcOpenShell: IfcConvert model.ifc model.glb.",
    ".rvt": "In Revit: Export, IFC; then IfcConvert model.ifc model.glb of IfcOpenShell.",
    ".skp": "In SketchUp: File, Export, 3D Model, glTF Binary (.glb).",
    **dict.fromkeys((".step", ".stp", ".iges", ".igs"), "In FreeCAD: File, Export, glTF 2.0 (.glb)."),
    **dict.fromkeys((".las", ".laz", ".e57", ".pcd", ".pts", ".xyz"), _POINTS),
    **dict.fromkeys((".zip", ".7z"), "Unpack it, and name the model in it."),
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
