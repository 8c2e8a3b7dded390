"""Data of glTF that optional libraries unpack: buffers by meshopt, textures by Basis Universal (KTX2)."""

from __future__ import annotations

import struct
from typing import Any

from PIL import Image

from tacos_framework import Fault, UserError
from tacos_framework.files import limits, too_large
from tacos_worlds.kit.mesh_files.damage import Damaged

MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
BASISU = "KHR_texture_basisu"
REMEDIES = {
    **dict.fromkeys(
        MESHOPT,
        "pip install 'tacos-framework[meshopt]', or run gltfpack without -c and -cc, or `gltf-transform copy "
        "in.glb out.glb`",
    ),
    BASISU: "pip install 'tacos-framework[ktx2]', or export textures as PNG or JPEG: gltfpack without -tc, "
    "or `gltf-transform ktxdecompress in.glb out.glb`",
}
_KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n"


def is_ktx2(content: bytes) -> bool:
    return content.startswith(_KTX2)


def ktx2_bytes(content: bytes) -> int:
    """Memory of the decoded texture, by its header [bytes]."""
    if len(content) < 28:
        raise Damaged("a texture of KTX2 ends within its header")
    width, height = struct.unpack_from("<II", content, 20)
    return 4 * int(width) * int(height)


def ktx2_picture(content: bytes, where: str, name: str) -> Image.Image:
    """The largest level of a texture of KTX2."""
    try:
        import opengl_basisu as basisu
    except ImportError as error:
        raise Damaged(f"{name} is a texture of KTX2: {REMEDIES[BASISU]}") from error
    if ktx2_bytes(content) > limits().bytes_of("image_mb"):
        raise UserError(too_large(where, f"the texture {name}", ktx2_bytes(content), "image_mb"))
    try:
        return Image.fromarray(basisu.Texture(content).transcode(basisu.Target.RGBA8).data)
    except ValueError as error:
        what = f"{name} is a texture of KTX2 that cannot be unpacked: {error}"
        raise UserError(Fault(where, what, "Basis Universal", "Export textures as PNG or JPEG.")) from error


def meshopt_view(content: bytes, packed: dict[str, Any], extension: str, where: str) -> memoryview:
    """The bytes of a view that an extension has packed."""
    try:
        import meshopt
    except ImportError as error:
        raise Damaged(f"it is compressed by {extension}: {REMEDIES[extension]}") from error
    count, stride = int(packed["count"]), int(packed["byteStride"])
    if count * stride > limits().bytes_of("mesh_mb"):
        raise UserError(too_large(where, "a buffer, unpacked,", count * stride, "mesh_mb"))
    try:
        mode, way = str(packed["mode"]), packed.get("filter", "NONE")
        rows = meshopt.decode_gltf_buffer(content, count, stride, mode, way)
    except (ValueError, RuntimeError) as error:
        raise Damaged(f"its data packed by {extension} cannot be unpacked: {error}") from error
    return memoryview(rows.tobytes())
