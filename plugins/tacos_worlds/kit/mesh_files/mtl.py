"""Libraries of materials of OBJ files.

Source: Ramey, Rose and Tyerman 1995, "MTL material format (Lightwave, OBJ)", version 4.2.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

_VALUES = {
    "-blendu": 1, "-blendv": 1, "-cc": 1, "-clamp": 1, "-mm": 2, "-texres": 1, "-bm": 1, "-boost": 1,
    "-imfchan": 1, "-type": 1, "-colorspace": 1, "-o": 3, "-s": 3, "-t": 3,
}  # fmt: skip
"""Values after each option, at most."""
_AS_MANY_AS_ARE_NUMBERS = ("-o", "-s", "-t")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_OPTION = re.compile(r"-[a-z]+", re.IGNORECASE)
_COMMENT = re.compile(r"(\.\w{3,4}) +#.*")
"""After the name of a picture, which may hold a # itself, as names of 3ds Max do."""
_PICTURES = re.compile(r"(map_\w+|bump|norm|disp|decal|refl)", re.IGNORECASE)
_EFFECTS = {
    "map_ka": "it has no effect: light is computed",
    "map_pr": "Pr holds all over a surface",
    "map_pm": "Pm holds all over a surface",
    "map_ks": "highlights are alike all over a surface",
    "map_ns": "highlights are alike all over a surface",
    "map_ke": "surfaces do not glow in a pattern",
    "map_bump": "surfaces are smooth",
    "bump": "surfaces are smooth",
    "norm": "surfaces are smooth",
    "disp": "surfaces are smooth",
    "decal": "the picture upon another is not drawn",
    "refl": "it has no effect: reflections are computed",
    "tf": "glass does not tint the light that passes",
}
_OPTION_EFFECTS = {
    "-t": "textures are not stirred by turbulence",
    "-mm": "textures keep the brightness of their picture",
    "-cc": "textures keep the colours of their picture",
    "-imfchan": "textures take all channels of their picture",
}
_NO_EFFECT = "it has no effect"
_READ = {"", "#", "d", "illum", "ka", "kd", "ke", "ks", "newmtl", "ni", "ns", "pm", "pr", "sharpness", "tr"}


@dataclass(frozen=True)
class MtlMaterial:
    """What a library says of a material.

    - `diffuse`: kd, linear; None where it says none [1].
    - `picture`, `mask_picture`: names of the pictures of map_Kd and map_d; empty where there are none.
    - `shininess`: ns, the exponent of its highlights [1].
    - `opacity`: 0 for what is not there [1].
    - `scale`, `offset`: of texture coordinates: ``uv * scale + offset`` [1, tiles].
    - `clamped`: whether the texture ends at its edges.
    - `emission`: light sent out, in the file's unit.
    - `roughness`, `metallic`: as Pr and Pm give them, which exporters of physically based materials write
      [1].
    - `library`: the name of its library, from whose folder those of pictures may start.
    """

    diffuse: tuple[float, ...] | None = None
    picture: str = ""
    mask_picture: str = ""
    shininess: float = 1.0
    opacity: float = 1.0
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamped: bool = False
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    roughness: float | None = None
    metallic: float = 0.0
    library: str = ""


@dataclass(frozen=True)
class Library:
    """A library of materials.

    - `materials`: by name.
    - `notes`: what is not carried out, each with its effect.
    """

    materials: Mapping[str, MtlMaterial]
    notes: tuple[str, ...]


def read_library(texts: Mapping[str, str]) -> Library:
    """Read the texts of MTL files, by name, as one library.

    >>> text = "newmtl Floor\\nd 0.2\\nmap_Kd -s 2 3 1 floor tile.png\\n"
    >>> floor = read_library({"room.mtl": text}).materials["Floor"]
    >>> floor.picture, floor.scale
    ('floor tile.png', (2.0, 3.0))
    """
    materials: dict[str, MtlMaterial] = {}
    notes: dict[str, None] = {}
    name = ""
    for library, line in ((library, line) for library, text in texts.items() for line in text.splitlines()):
        word, _, rest = line.strip().replace("\t", " ").partition(" ")
        key, rest = word.lower(), rest.strip()
        if key == "newmtl":
            name = rest
            materials[name] = MtlMaterial(library=library)
        elif name not in materials:
            continue
        elif _PICTURES.fullmatch(word):
            options, picture = split_options(_COMMENT.sub(r"\1", rest))
            if key == "map_kd":
                materials[name] = replace(_moved(materials[name], options), picture=picture)
                known = {**dict.fromkeys(options.keys() - _VALUES, _NO_EFFECT), **_OPTION_EFFECTS}
                notes |= dict.fromkeys(f"{each}: {known[each]}" for each in options if each in known)
            elif key == "map_d":
                materials[name] = replace(materials[name], mask_picture=picture)
            else:
                notes[f"{key} is not carried out: {_EFFECTS.get(key, _NO_EFFECT)}"] = None
        else:
            white = key == "tf" and set(_numbers(rest.split())) == {1.0}
            if key not in _READ and not key.startswith("#") and not white:
                notes[f"{word} is not carried out: {_EFFECTS.get(key, _NO_EFFECT)}"] = None
            elif rest.split()[:1] in (["spectral"], ["xyz"]):
                notes[f"{word} {rest.split()[0]} is not carried out: give red, green and blue"] = None
            materials[name] = _with(materials[name], key, _numbers(rest.partition("#")[0].split()))
    if materials and all(each.opacity < 0.5 for each in materials.values()):
        notes["d or Tr says that all is clear, which is taken as all opaque"] = None
        materials = {key: replace(each, opacity=1.0) for key, each in materials.items()}
    return Library(materials, tuple(notes))


def split_options(rest: str) -> tuple[dict[str, list[str]], str]:
    """Options before the name of a picture, with their values, and that name, which may hold spaces."""
    options: dict[str, list[str]] = {}
    words, at = rest.split(), 0
    while at < len(words) - 1 and _OPTION.fullmatch(words[at]):
        option = words[at].lower()
        end = at + 1 + _VALUES.get(option, 1)
        if option in _AS_MANY_AS_ARE_NUMBERS:
            end = at + 1
            while end < min(len(words), at + 4) and _NUMBER.fullmatch(words[end]):
                end += 1
        options[option] = words[at + 1 : end]
        at = end
    name = rest.strip().split(maxsplit=at)[-1] if at < len(words) else ""
    return options, name.strip('"')


def _moved(material: MtlMaterial, options: Mapping[str, list[str]]) -> MtlMaterial:
    scale = [*_numbers(options.get("-s", [])), 1.0, 1.0]
    if len(options.get("-s", [])) == 1:
        scale[1] = 1.0
    offset = [*_numbers(options.get("-o", [])), 0.0, 0.0]
    clamped = [value.lower() for value in options.get("-clamp", [])] == ["on"]
    return replace(material, scale=(scale[0], scale[1]), offset=(offset[0], offset[1]), clamped=clamped)


def _with(material: MtlMaterial, key: str, values: list[float]) -> MtlMaterial:
    if key == "kd" and values:
        return replace(material, diffuse=tuple((values * 3)[:3]))
    if key == "ns" and values:
        return replace(material, shininess=max(values[0], 0.0))
    if key == "d" and values:
        return replace(material, opacity=values[-1])
    if key == "tr" and values:
        return replace(material, opacity=1.0 - values[0])
    if key == "pr" and values:
        return replace(material, roughness=values[0])
    if key == "pm" and values:
        return replace(material, metallic=min(max(values[0], 0.0), 1.0))
    if key == "ke" and len(values) == 3:
        return replace(material, emission=(values[0], values[1], values[2]))
    return material


def _numbers(words: Iterable[str]) -> list[float]:
    return [float(word) for word in words if _NUMBER.fullmatch(word)]
