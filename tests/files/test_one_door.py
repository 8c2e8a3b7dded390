"""Files from outside are read through `tacos_framework.files`, and `tacos_files` on top of it, alone."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
READING = {
    "np.load",
    "np.loadtxt",
    "np.genfromtxt",
    "np.fromfile",
    "cv2.imread",
    "cv2.imdecode",
    "Image.open",
    "Pillow.open",
    "rawpy.imread",
    "trimesh.load",
    "trimesh.load_scene",
    "trimesh.load_mesh",
    "yaml.load",
    "yaml.safe_load",
    "json.load",
    "torch.load",
    "load_file",
    "safe_open",
    "zipfile.ZipFile",
    "tarfile.open",
}
METHODS = {"read_text", "read_bytes"}
DOOR = ("tacos_framework/files/", "plugins/tacos_files/")
ALLOWED = {
    "tacos_framework/store/": "files of a run, with digests in its database",
    "plugins/tacos_gap/photographs/facts.py": "Pillow, given bytes of a regular file; samples stay undecoded",
    "plugins/tacos_plugins/tasks/learning/checkpoints.py": "torch, given bytes of a regular file",
    "plugins/tacos_plugins/effects/jpeg.py": "decodes what it has just encoded",
    "plugins/tacos_plugins/renderers/blender/inside_blender.py": "imports nothing of ours; reads its job",
    "plugins/tacos_worlds/imported/sky.py": "cv2, given bytes of a regular file, its size checked",
    "plugins/tacos_plugins/renderers/moderngl/programs.py": "shaders of the package",
    "plugins/tacos_plugins/executors/": "what the kernel and Ray say of this process",
    "plugins/tacos_plugins/kept_worlds/": "what this machine kept itself, with checksums of its own",
    "plugins/tacos_validation/blind/generators/": "knows nothing of the framework; reads what it wrote",
}


def sources() -> list[Path]:
    return sorted([*ROOT.glob("tacos_framework/**/*.py"), *ROOT.glob("plugins/**/*.py")])


def readings(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Lines of a module that read a file by themselves, and how."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        if name in READING or (isinstance(node.func, ast.Attribute) and node.func.attr in METHODS):
            yield node.lineno, name
        elif name == "open" or name.endswith((".open", "os.fdopen")):
            modes = [
                a.value
                for a in [*node.args, *(k.value for k in node.keywords)]
                if isinstance(a, ast.Constant)
            ]
            if not any(isinstance(mode, str) and set("wax") & set(mode) and len(mode) < 4 for mode in modes):
                yield node.lineno, name


def test_no_module_reads_files_by_itself():
    found = []
    for path in sources():
        name = path.relative_to(ROOT).as_posix()
        if not name.startswith((*DOOR, *ALLOWED)):
            found += [f"{name}:{line}: {how}" for line, how in readings(ast.parse(path.read_text("utf-8")))]
    assert not found, "read through tacos_framework.files or tacos_files: " + ", ".join(found)


@pytest.mark.parametrize("allowed", ALLOWED)
def test_every_exception_is_needed(allowed):
    paths = [path for path in sources() if path.relative_to(ROOT).as_posix().startswith(allowed)]
    assert any(any(readings(ast.parse(path.read_text("utf-8")))) for path in paths)
