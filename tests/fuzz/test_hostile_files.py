"""Files made to do harm: bombs, pipes, links, names that lead elsewhere."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
import zipfile
import zlib
from functools import partial
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from tacos_files.arrays import read_npy, read_npz
from tacos_files.images import read_samples
from tacos_framework.errors import UserError
from tacos_framework.files import limits, read_bytes, read_csv, read_json, read_text
from tacos_worlds.kit.mesh_files import read_model

READERS = {
    "text": read_text,
    "json": read_json,
    "csv": read_csv,
    "npy": read_npy,
    "npz": read_npz,
    "png": read_samples,
}
MEASURED = """
import resource, sys
from functools import partial
from pathlib import Path
from tacos_framework.errors import UserError
from tacos_files.arrays import read_npz
from tacos_files.images import read_samples
from tacos_worlds.kit.mesh_files import read_model
import cv2
model = partial(read_model, most_px=64)
readers = {".png": read_samples, ".tif": read_samples, ".npz": read_npz, ".glb": model}
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for name in sys.argv[1:]:
    try:
        readers[Path(name).suffix](Path(name))
    except UserError as error:
        print(Path(name).suffix, error.faults[0])
    print("grown by", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
READ_MODEL = partial(read_model, most_px=64)
GROWTH_KIB = 200 * 1024


def fault_of(read, *given, **named) -> str:
    with pytest.raises(UserError) as error:
        read(*given, **named)
    return str(error.value)


def png_of(width: int, height: int) -> bytes:
    """A PNG of 16-bit RGB with a size of its own and hardly any bytes."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
    packed = zlib.compress(bytes(10_000_000), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def glb_of(tree: dict, binary: bytes = b"") -> bytes:
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        parts += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts


def claiming(count: int) -> bytes:
    """A GLB whose accessors claim many vertices and have no data."""
    accessors = [{"componentType": 5126, "type": "VEC3", "count": count}]
    primitives = [{"attributes": {"POSITION": 0}}]
    return glb_of(
        {
            "asset": {"version": "2.0"},
            "bufferViews": [],
            "accessors": accessors,
            "meshes": [{"primitives": primitives}],
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
        }
    )


def test_files_that_claim_gigabytes_take_no_memory(tmp_path):
    (tmp_path / "bomb.png").write_bytes(png_of(20_000, 20_000))
    (tmp_path / "bomb.glb").write_bytes(claiming(3 * 10**8))
    entries = [(256, 4, 1, 60_000), (257, 4, 1, 60_000), (258, 3, 1, 16), (277, 3, 1, 3), (273, 4, 1, 8)]
    tiff = b"II*\0" + struct.pack("<IH", 8, len(entries))
    (tmp_path / "bomb.tif").write_bytes(tiff + b"".join(struct.pack("<HHII", *each) for each in entries))
    stream = BytesIO()
    np.lib.format.write_array(stream, np.zeros(60_000_000, np.uint8))
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        for name in "abcdefgh":
            archive.writestr(f"{name}.npy", stream.getvalue())
    del stream
    bombs = sorted(map(str, tmp_path.iterdir()))
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, *bombs], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.count("TACOS_LIMITS=") == 4, done.stdout
    grown = [int(line.split()[-1]) for line in done.stdout.splitlines() if line.startswith("grown")]
    assert len(grown) == len(bombs)
    assert max(grown) < GROWTH_KIB


@pytest.mark.parametrize("name", READERS)
def test_only_regular_files_are_read(name, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "is a named pipe" in fault_of(READERS[name], tmp_path / "pipe")  # which nobody ever writes to
    assert "is a folder" in fault_of(READERS[name], tmp_path)
    assert "is a device" in fault_of(READERS[name], Path("/dev/zero"))
    assert "there is no file" in fault_of(READERS[name], tmp_path / "none")


def test_links_may_not_leave_the_folder(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    (tmp_path / "secret").write_text("x")
    (inside / "own").write_text("y")
    (inside / "link").symlink_to(tmp_path / "secret")
    (inside / "alias").symlink_to(inside / "own")
    assert "leads out of" in fault_of(read_bytes, inside / "link", "text_mb", within=inside)
    assert "leads out of" in fault_of(read_bytes, inside / ".." / "secret", "text_mb", within=inside)
    assert read_bytes(inside / "alias", "text_mb", within=inside) == b"y"
    assert read_bytes(inside / "link", "text_mb") == b"x"


def test_limits_are_said_and_can_be_changed(tmp_path, monkeypatch):
    (tmp_path / "large.txt").write_bytes(b"a" * 1_500_000)
    said = fault_of(read_text, tmp_path / "large.txt")
    assert "large.txt is larger than 1000000 bytes: 1500000" in said
    assert "TACOS_LIMITS=text_mb=2 " in said
    monkeypatch.setenv("TACOS_LIMITS", "text_mb=2, json_mb=1")
    assert len(read_text(tmp_path / "large.txt")) == 1_500_000
    assert "Did you mean 'text_mb'" in fault_of(limits, "txt_mb=2")
    assert "a number above 0" in fault_of(limits, "text_mb=much")


def test_what_a_decoder_refuses_under_a_raised_limit_is_a_fault(tmp_path, monkeypatch):
    monkeypatch.setenv("TACOS_LIMITS", "image_mb=100000")
    (tmp_path / "huge.png").write_bytes(png_of(60_000, 60_000))  # OpenCV has a limit of its own
    assert "huge.png is damaged: " in fault_of(read_samples, tmp_path / "huge.png")


def test_models_may_not_name_files_elsewhere(tmp_path):
    folder = tmp_path / "models"
    folder.mkdir()
    (tmp_path / "secret.bin").write_bytes(b"secret")
    for uri in (
        "../secret.bin",
        "%2e%2e/secret.bin",
        "/etc/passwd",
        "http://example.org/a.bin",
        "file:///etc/passwd",
    ):
        tree = {
            "asset": {"version": "2.0"},
            "images": [{"uri": uri}],
            "textures": [{"source": 0}],
            "materials": [{"normalTexture": {"index": 0}}],
        }
        (folder / "model.gltf").write_text(json.dumps(tree))
        assert "refers to" in fault_of(READ_MODEL, folder / "model.gltf"), uri


def test_a_truncated_texture_is_a_fault(tmp_path):
    (tmp_path / "m.obj").write_text(
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"
    )
    (tmp_path / "m.mtl").write_text("newmtl a\nmap_Kd t.png\n")
    whole = png_of(10, 10)
    (tmp_path / "t.png").write_bytes(whole[: len(whole) // 2])
    assert "t.png is no image that can be read: it breaks off" in fault_of(READ_MODEL, tmp_path / "m.obj")
    tree = {
        "asset": {"version": "2.0"},
        "images": [{"uri": "t.png"}],
        "textures": [{"source": 0}],
        "materials": [{"normalTexture": {"index": 0}}],
    }
    (tmp_path / "m.glb").write_bytes(glb_of(tree))
    assert "picture 0 is no image that can be read" in fault_of(READ_MODEL, tmp_path / "m.glb")


def test_a_scene_that_copies_itself_without_end_is_a_fault(tmp_path):
    nodes = [{"children": [i + 1, i + 1]} for i in range(40)] + [{}]
    (tmp_path / "m.glb").write_bytes(
        glb_of({"asset": {"version": "2.0"}, "nodes": nodes, "scenes": [{"nodes": [0]}]})
    )
    assert "more than once" in fault_of(READ_MODEL, tmp_path / "m.glb")


def test_texts_of_no_length_are_no_array(tmp_path) -> None:
    stream = BytesIO()
    np.save(stream, np.zeros(3, "U1"))
    empty = stream.getvalue().replace(b"'<U1'", b"'<U0'")[:128]
    with zipfile.ZipFile(tmp_path / "names.npz", "w") as archive:
        archive.writestr("names.npy", empty)
    assert "names.npz: names holds texts of no letters" in fault_of(read_npz, tmp_path / "names.npz")
