"""What a glTF file uses and is not carried out: each once, with its effect."""

from __future__ import annotations

from collections.abc import Iterator

from tacos_worlds.kit.mesh_files.gltf_buffers import Buffers, Json
from tacos_worlds.kit.mesh_files.packed import BASISU, MESHOPT, REMEDIES

DRACO = "KHR_draco_mesh_compression"
SPECULAR_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
_CARRIED_OUT = {
    DRACO,
    *MESHOPT,
    BASISU,
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    SPECULAR_GLOSSINESS,
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
}
_EFFECTS = {
    "KHR_materials_specular": "highlights have the strength of common plastics and paints",
    "KHR_materials_clearcoat": "lacquer over a surface is not drawn",
    "KHR_materials_sheen": "cloth has no sheen",
    "KHR_materials_volume": "thick glass neither bends nor tints light",
    "KHR_materials_iridescence": "films do not shimmer in colours",
    "KHR_materials_anisotropy": "brushed metal mirrors alike in all directions",
    "KHR_materials_dispersion": "glass does not split colours",
    "FB_ngon_encoding": "polygons are drawn as their triangles",
    "KHR_materials_variants": "the first look of each surface is drawn",
}
UNDERSTOOD = _CARRIED_OUT | _EFFECTS.keys()
"""Extensions without which a file that requires them is still read as it is meant, or nearly so."""
_REMEDIES = {
    DRACO: "pip install 'tacos-framework[draco]', or export it with Compression off (Blender: Data, Mesh)",
    **REMEDIES,
}
_CLEAR = 0.9
"""Base colour of glass from which on it counts as without a tint [1]."""
_MODES = {0: "points", 1: "lines", 2: "lines", 3: "lines"}


def remedy_for(extension: str) -> str:
    """Which setting of an exporter leaves an extension out."""
    return _REMEDIES.get(extension, "export it without that extension")


def notes_on(buffers: Buffers) -> Iterator[str]:
    """What is left out of a file that is read, and what follows for the image."""
    used = sorted({str(name) for name in buffers.header.get("extensionsUsed", [])})
    for name in used:
        if name not in _CARRIED_OUT:
            yield f"{name} is not carried out: {_EFFECTS.get(name, 'it has no effect')}"
    primitives = [part for mesh in buffers.listed("meshes") for part in mesh.get("primitives", [])]
    modes = [_MODES[part["mode"]] for part in primitives if part.get("mode") in _MODES]
    for kind in sorted(set(modes)):
        yield f"{modes.count(kind)} sets of {kind} are left out: only triangles are drawn"
    attributes = {name for part in primitives for name in part.get("attributes", {})}
    if buffers.listed("animations"):
        yield "animations are not played: all stands as at the start"
    if further := sorted(name for name in attributes if name.startswith("COLOR_") and name != "COLOR_0"):
        yield f"{', '.join(further)}: only the first set of vertex colours counts"
    if len(scenes := buffers.listed("scenes")) > 1:
        yield f"only the default of {len(scenes)} scenes is there"
    if buffers.listed("cameras"):
        yield "cameras of the file are not used: those of the study look"
    lights = buffers.header.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    if any(light.get("type") == "spot" for light in lights):
        yield "spots shine as small squares of as many candela ahead, whatever their cone"
    if any("range" in light for light in lights):
        yield "the range of lights has no effect: light falls with the square of the distance"
    yield from _of_materials(buffers, primitives)


def _of_materials(buffers: Buffers, primitives: list[Json]) -> Iterator[str]:
    def named(materials: list[str]) -> str:
        return ", ".join(materials[:5]) + (f" and {len(materials) - 5} more" if len(materials) > 5 else "")

    blended, mixed, glowing, apart, faded, stained = [], [], [], [], [], []
    tinted = {
        part.get("material")
        for part in primitives
        if "COLOR_0" in part.get("attributes", {})
        and buffers.entry("accessors", part["attributes"]["COLOR_0"]).get("type") == "VEC4"
    }
    for index, material in enumerate(buffers.listed("materials")):
        name = str(material.get("name", f"material {index}"))
        pbr = material.get("pbrMetallicRoughness") or {}
        if material.get("alphaMode") == "BLEND" and "baseColorTexture" in pbr:
            blended.append(name)
        more = material.get("extensions", {})
        if "metallicRoughnessTexture" in pbr or "specularGlossinessTexture" in more.get(
            SPECULAR_GLOSSINESS, {}
        ):
            mixed.append(name)
        if "KHR_materials_transmission" in more and min(pbr.get("baseColorFactor", (1, 1, 1))[:3]) < _CLEAR:
            stained.append(name)
        if "emissiveTexture" in material and any(material.get("emissiveFactor", (0, 0, 0))):
            glowing.append(name)
        others = [pbr.get("metallicRoughnessTexture"), material.get("normalTexture")]
        places = [_place(info) for info in (pbr.get("baseColorTexture"), *others) if info]
        if any(place != places[0] for place in places):
            apart.append(name)
        if material.get("alphaMode", "OPAQUE") != "OPAQUE" and index in tinted:
            faded.append(name)
    if apart:
        yield f"{named(apart)}: textures with coordinates of their own are drawn by those of the colours"
    if faded:
        yield f"{named(faded)}: opacity of vertices is not carried out"
    if blended:
        yield f"{named(blended)}: alphaMode BLEND is drawn where its texture is opaque from half on"
    if stained:
        yield f"{named(stained)}: glass does not tint the light that passes"
    if mixed:
        yield f"{named(mixed)}: roughness and metalness of a texture count by their mean"
    if glowing:
        yield f"{named(glowing)}: light of an emissive texture counts by its mean"


def _place(texture: Json) -> tuple[object, object]:
    return texture.get("texCoord", 0), texture.get("extensions", {}).get("KHR_texture_transform")
