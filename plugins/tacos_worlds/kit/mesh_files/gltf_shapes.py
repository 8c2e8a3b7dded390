"""What of the JSON of a glTF file is read, and the types of its entries; their names are glTF's.

References
----------
glTF 2.0: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, FiniteFloat

TRIANGLES = 4
"""The mode of a primitive whose corners stand three by three."""

_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_MOST_NODES = 100_000

Count = Annotated[int, Field(strict=True, ge=0, lt=2**40)]


class GltfBufferView(BaseModel):
    buffer: Count
    byteOffset: Count = 0
    byteLength: Count
    byteStride: Annotated[int, Field(strict=True, ge=1, le=252)] | None = None


class GltfAccessor(BaseModel):
    bufferView: Count | None = None
    byteOffset: Count = 0
    componentType: Literal[5120, 5121, 5122, 5123, 5125, 5126]
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    count: Count
    sparse: Any = None

    @property
    def item_bytes(self) -> int:
        return _COMPONENT_BYTES[self.componentType] * _COMPONENTS[self.type]


class GltfPrimitive(BaseModel):
    attributes: dict[str, Count]
    indices: Count | None = None
    material: Count | None = None
    mode: Annotated[int, Field(strict=True, ge=0, le=6)] = TRIANGLES


class GltfMesh(BaseModel):
    primitives: list[GltfPrimitive]


class GltfNode(BaseModel):
    mesh: Count | None = None
    children: list[Count] = []
    matrix: Annotated[list[FiniteFloat], Field(min_length=16, max_length=16)] | None = None
    translation: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = None
    rotation: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] | None = None
    scale: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = None


class GltfScene(BaseModel):
    nodes: list[Count] = []


class GltfBuffer(BaseModel):
    byteLength: Count
    uri: str | None = None


class GltfImage(BaseModel):
    uri: str | None = None
    bufferView: Count | None = None
    mimeType: str = ""


class GltfTextureInfo(BaseModel):
    index: Count


class GltfReflection(BaseModel):
    baseColorFactor: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] | None = None
    baseColorTexture: GltfTextureInfo | None = None
    metallicFactor: FiniteFloat | None = None
    roughnessFactor: FiniteFloat | None = None
    metallicRoughnessTexture: GltfTextureInfo | None = None


class GltfMaterial(BaseModel):
    pbrMetallicRoughness: GltfReflection = GltfReflection()
    normalTexture: GltfTextureInfo | None = None
    occlusionTexture: GltfTextureInfo | None = None
    emissiveTexture: GltfTextureInfo | None = None
    emissiveFactor: tuple[FiniteFloat, FiniteFloat, FiniteFloat] | None = None

    @property
    def textures(self) -> list[int]:
        """Indices of the textures it has."""
        own = self.pbrMetallicRoughness
        named = (own.baseColorTexture, own.metallicRoughnessTexture, self.normalTexture)
        return [each.index for each in (*named, self.occlusionTexture, self.emissiveTexture) if each]


class GltfTexture(BaseModel):
    source: Count | None = None


class GltfFile(BaseModel):
    extensionsRequired: list[str] = []
    buffers: list[GltfBuffer] = []
    bufferViews: list[GltfBufferView] = []
    accessors: list[GltfAccessor] = []
    meshes: list[GltfMesh] = []
    nodes: Annotated[list[GltfNode], Field(max_length=_MOST_NODES)] = []
    scenes: list[GltfScene] = []
    scene: Count = 0
    images: list[GltfImage] = []
    materials: list[GltfMaterial] = []
    textures: list[GltfTexture] = []
