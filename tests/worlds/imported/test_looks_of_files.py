"""Masks, samplers, tints and materials of files, as their formats mean them."""

from __future__ import annotations

import io
import json
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from PIL import Image

from tacos_framework.errors import UserError
from tacos_view.pictures import png_uri
from tacos_worlds.imported.reader import read_world
from tacos_worlds.kit.mesh_files import read_model
from tacos_worlds.kit.mesh_files.mtl import read_library, split_options
from tacos_worlds.kit.models.cutouts import cut_out, without_clear
from tacos_worlds.kit.models.mask_outlines import outlines
from tacos_worlds.kit.models.model import Model, Skin, Surface
from tacos_worlds.kit.models.patch import Patch
from tacos_worlds.kit.models.tints import tinted

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def area(surface: Surface) -> float:
    a, b, c = (surface.vertices[surface.triangles[:, corner]] for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2


def square(uv: np.ndarray, **skin: Any) -> Model:
    surface = Surface(("sheet",), SQUARE, TWO, 0, uv=uv, normals=np.tile([0.0, 0, 1], (4, 1)))
    return Model((surface,), (Skin("s", **skin),))


@settings(max_examples=40, deadline=None)
@given(
    columns=st.lists(st.booleans(), min_size=4, max_size=16),
    tiles=st.integers(1, 3),
    turn=st.floats(-3, 3),
    move=st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
)
def test_bars_leave_the_share_of_a_sheet_that_is_opaque(
    columns: list[bool], tiles: int, turn: float, move: tuple[float, float]
) -> None:
    """A sampler that blends puts edges halfway between texels, so that shares are those of the texels."""
    assume(any(columns) and not all(columns))
    mask = np.tile(np.array(columns, np.uint8) * 255, (len(columns), 1))
    cut = cut_out(square(SQUARE[:, :2] * tiles, mask=mask)).surfaces[0]
    assert area(cut) == pytest.approx(np.mean(columns), abs=1e-6)
    assert cut.normals is not None
    np.testing.assert_allclose(cut.normals, np.tile([0.0, 0, 1], (len(cut.normals), 1)), atol=1e-9)
    turned = SQUARE[:, :2] @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) + move
    anywhere = cut_out(square(turned, mask=mask)).surfaces[0]
    assert area(anywhere) <= 1 + 1e-6


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), cutoff=st.floats(0.2, 0.8))
def test_what_is_left_of_a_sheet_is_where_its_mask_is_above_the_cutoff(seed: int, cutoff: float) -> None:
    rng = np.random.default_rng(seed)
    mask = rng.integers(0, 256, (6, 9), dtype=np.uint8)
    cut = cut_out(square(SQUARE[:, :2], mask=mask, cutoff=cutoff)).surfaces[0]
    assume(len(cut.triangles))
    corners = cut.vertices[cut.triangles][..., :2]
    first, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    for row, column in np.argwhere(np.abs(mask - 255 * cutoff) > 1):  # else a speck has no area
        at = np.array([(column + 0.5) / 9, (row + 0.5) / 6]) - first
        second = (at[:, 0] * v[:, 1] - at[:, 1] * v[:, 0]) / doubled
        third = (u[:, 0] * at[:, 1] - u[:, 1] * at[:, 0]) / doubled
        least = np.minimum(np.minimum(second, third), 1 - second - third).max()
        assert least > -1e-6 if mask[row, column] >= 255 * cutoff else least < 1e-6
    crosses = np.cross(
        cut.vertices[cut.triangles[:, 1]] - cut.vertices[cut.triangles[:, 0]],
        cut.vertices[cut.triangles[:, 2]] - cut.vertices[cut.triangles[:, 0]],
    )
    assert (crosses[:, 2] > 0).all()


@settings(max_examples=8, deadline=None)
@given(tiles=st.integers(1, 60), across=st.booleans())
def test_bars_of_a_fence_take_few_triangles_and_too_many_are_told(tiles: int, across: bool) -> None:
    mask = np.tile(np.array([255, 0, 0, 0], np.uint8), (64, 16))
    made = cut_out(square(SQUARE[:, :2] * [tiles, 1], mask=mask.T if across else mask))
    cut = made.surfaces[0]
    assert len(cut.triangles) <= 16 * tiles * 16
    assert area(cut) == pytest.approx(0.25) or "too finely" in made.notes[0]


def test_a_mask_that_repeats_beyond_what_is_seen_is_told() -> None:
    mask = np.tile(np.array([255, 0, 0, 0], np.uint8), (64, 16))
    made = cut_out(square(SQUARE[:, :2] * 300, mask=mask))
    assert made.notes == ("s: its mask repeats too finely to be cut out, and is left out",)


def test_outlines_stay_within_bounds_on_triangles() -> None:
    rng = np.random.default_rng(0)
    mask = rng.integers(0, 256, (256, 256), dtype=np.uint8)
    cut = cut_out(square(SQUARE[:, :2] * 20, mask=mask)).surfaces[0]
    assert len(cut.triangles) < 300_000
    assert outlines(np.full((4, 4), -1.0), (False, False)).shape == (0, 8, 2)


def test_a_texture_that_ends_at_its_edges_is_held_there() -> None:
    held = cut_out(square(SQUARE[:, :2] * 3 - 1, clamped=(True, True))).surfaces[0]
    assert held.uv is not None
    assert held.uv.min() == pytest.approx(0, abs=1e-9)
    assert held.uv.max() == pytest.approx(1, abs=1e-9)
    assert area(held) == pytest.approx(1)
    middle = np.abs(held.vertices[:, :2] - 0.5).max(axis=1) < 1 / 6 - 1e-9
    np.testing.assert_allclose(held.uv[middle], held.vertices[middle, :2] * 3 - 1, atol=1e-9)


def patch(colours: np.ndarray, uv: np.ndarray | None = None) -> Patch:
    return Patch(SQUARE, TWO, 0, 0, uv=uv, colours=colours)


def test_white_colours_change_nothing_and_one_colour_multiplies() -> None:
    texture = np.zeros((2, 2, 3), np.uint8)
    skin = Skin("wall", np.full(3, 0.8), texture=texture, roughness=0.3)
    (white,), skins, atlases = tinted([patch(np.ones((4, 3)), SQUARE[:, :2])], [skin])
    assert (white.skin, white.colours, atlases) == (0, None, {})
    (half,), skins, _ = tinted([patch(np.full((4, 3), 0.5), SQUARE[:, :2])], [skin])
    assert skins[half.skin].base_colour == pytest.approx(np.full(3, 0.4))
    assert skins[half.skin].texture is texture
    assert skins[half.skin].roughness == 0.3


def test_a_gradient_over_a_texture_keeps_the_texture_and_its_mean() -> None:
    colours = np.linspace(0.1, 0.9, 4)[:, None] * np.ones((1, 3))
    texture = np.zeros((2, 2, 3), np.uint8)
    parts, skins, _ = tinted([patch(colours, SQUARE[:, :2])], [Skin("w", np.ones(3), texture=texture)])
    assert all(skins[part.skin].texture is texture for part in parts)
    areas = np.array([part.areas_m2.sum() for part in parts])
    tone = np.array([skins[part.skin].base_colour[0] for part in parts])
    mean = colours[TWO].mean()
    assert areas.sum() == pytest.approx(1)
    assert float(areas @ tone) == pytest.approx(mean, rel=0.03)


@settings(max_examples=40, deadline=None)
@given(
    corners=st.lists(st.tuples(*[st.floats(0.01, 1)] * 3), min_size=4, max_size=4),
    base=st.tuples(*[st.floats(0, 1)] * 3),
)
def test_any_colours_over_a_texture_keep_it_and_tint_each_place(
    corners: list[tuple[float, ...]], base: tuple[float, ...]
) -> None:
    """Within the steps that a gradient is cut into; nothing of the surface is lost."""
    texture = np.zeros((2, 2, 3), np.uint8)
    skin = Skin("w", np.array(base), texture=texture)
    colours = np.array(corners)
    parts, skins, _ = tinted([patch(colours, SQUARE[:, :2])], [skin])
    assert sum(part.areas_m2.sum() for part in parts) == pytest.approx(1)
    for part in parts:
        tint = skins[part.skin]
        assert tint.texture is texture
        np.testing.assert_allclose(part.uv, part.vertices_m[:, :2], atol=1e-9)
        assert (tint.base_colour >= np.array(base) * colours.min(axis=0) - 2e-3).all()
        assert (tint.base_colour <= np.array(base) * colours.max(axis=0) + 2e-3).all()
    weights = np.array([part.areas_m2.sum() for part in parts])
    mean = weights @ np.stack([skins[part.skin].base_colour for part in parts])
    np.testing.assert_allclose(mean, np.array(base) * colours[TWO].mean(axis=(0, 1)), atol=0.03)


def test_colours_without_a_texture_multiply_the_colour_of_the_material() -> None:
    colours = np.linspace(0.2, 1, 4)[:, None] * np.ones((1, 3))
    skin = Skin("w", np.array([1.0, 0, 0]), roughness=0.2, metallic=1.0)
    (painted,), skins, atlases = tinted([patch(colours)], [skin])
    assert (skins[painted.skin].roughness, skins[painted.skin].metallic) == (0.2, 1.0)
    assert atlases[painted.skin][..., 0].max() > 0
    assert atlases[painted.skin][..., 1:].max() == 0


def gltf(folder: Path, **more: object) -> Path:
    corners = SQUARE.astype("<f4").tobytes() + SQUARE[:, :2].astype("<f4").tobytes()
    corners += TWO.astype("<u2").tobytes()
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": f"data:;base64,{b64encode(corners).decode()}", "byteLength": len(corners)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}
        ],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{}],
        "images": [
            {"uri": png_uri(np.array([[[10, 0, 0], [20, 0, 0]], [[30, 0, 0], [40, 0, 0]]], np.uint8))}
        ],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        **more,
    }
    file = folder / "square.gltf"
    file.write_text(json.dumps(tree), encoding="utf-8")
    return file


def colour_at(model: Model, u: float, v: float) -> int:
    """Red of the texel at a place of the square, as a sampler that repeats finds it."""
    surface, skin = model.surfaces[0], model.skins[0]
    assert surface.uv is not None
    assert skin.texture is not None
    origin, along_u, along_v = surface.uv[0], surface.uv[1] - surface.uv[0], surface.uv[3] - surface.uv[0]
    at = (origin + u * along_u + v * along_v) % 1
    rows, columns = skin.texture.shape[:2]
    return int(skin.texture[int(at[1] * rows), int(at[0] * columns), 0])


@given(u=st.floats(0.01, 0.99), v=st.floats(0.01, 0.99))
@pytest.mark.parametrize("wrap_s", [10497, 33648])
@pytest.mark.parametrize("wrap_t", [10497, 33648])
def test_textures_repeat_and_mirror_as_their_sampler_says(
    tmp_path_factory: pytest.TempPathFactory, wrap_s: int, wrap_t: int, u: float, v: float
) -> None:
    scale = {"extensions": {"KHR_texture_transform": {"scale": [4, 4], "offset": [-1, -1]}}}
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **scale}}}
    file = gltf(
        tmp_path_factory.mktemp("g"), samplers=[{"wrapS": wrap_s, "wrapT": wrap_t}], materials=[material]
    )
    x, y = 4 * u - 1, 4 * v - 1  # of glTF: rows downwards
    assume(all(abs(2 * at - round(2 * at)) > 1e-3 for at in (x, y)))

    def inside(at: float, wrap: int) -> float:
        return at % 1 if wrap == 10497 or int(np.floor(at)) % 2 == 0 else 1 - at % 1

    row, column = int(2 * inside(y, wrap_t)), int(2 * inside(x, wrap_s))
    assert colour_at(read_model(file, most_px=64), u, v) == 10 + 20 * row + 10 * column


@pytest.mark.parametrize("glossiness", [0.0, 0.2, 1.0])
def test_specular_glossiness_is_a_dielectric_of_its_diffuse_colour(tmp_path: Path, glossiness: float) -> None:
    look = {"diffuseTexture": {"index": 0}, "diffuseFactor": [0.5, 1, 1, 1], "glossinessFactor": glossiness}
    materials = [{"extensions": {"KHR_materials_pbrSpecularGlossiness": look}}]
    skin = read_model(gltf(tmp_path, materials=materials), most_px=64).skins[0]
    assert skin.texture is not None
    assert (skin.metallic, skin.roughness) == (0.0, pytest.approx(1 - glossiness))
    assert skin.base_colour == pytest.approx([0.5, 1, 1])


def test_glossiness_of_a_texture_counts(tmp_path: Path) -> None:
    look = {"specularGlossinessTexture": {"index": 0}, "glossinessFactor": 0.5}
    materials = [{"name": "m", "extensions": {"KHR_materials_pbrSpecularGlossiness": look}}]
    content = io.BytesIO()
    Image.new("RGBA", (4, 4), (9, 9, 9, 102)).save(content, "png")
    images = [{"uri": f"data:image/png;base64,{b64encode(content.getvalue()).decode()}"}]
    model = read_model(gltf(tmp_path, materials=materials, images=images), most_px=64)
    assert model.skins[0].roughness == pytest.approx(1 - 0.5 * 0.4)
    assert model.notes == ("m: roughness and metalness of a texture count by their mean",)


def test_a_black_and_bright_specular_material_is_a_metal(tmp_path: Path) -> None:
    look = {"diffuseFactor": [0, 0, 0, 1], "specularFactor": [0.9, 0.7, 0.3], "glossinessFactor": 0.6}
    materials = [{"extensions": {"KHR_materials_pbrSpecularGlossiness": look}}]
    skin = read_model(gltf(tmp_path, materials=materials), most_px=64).skins[0]
    assert (skin.metallic, skin.base_colour.tolist()) == (1.0, [0.9, 0.7, 0.3])


SHARES = st.floats(0, 1)


@given(
    diffuse=st.tuples(SHARES, SHARES, SHARES), specular=st.tuples(SHARES, SHARES, SHARES), glossiness=SHARES
)
def test_specular_glossiness_makes_no_light_and_no_mirror_of_what_is_dark(
    tmp_path_factory: pytest.TempPathFactory,
    diffuse: tuple[float, ...],
    specular: tuple[float, ...],
    glossiness: float,
) -> None:
    look = {"diffuseFactor": [*diffuse, 1], "specularFactor": specular, "glossinessFactor": glossiness}
    materials = [{"extensions": {"KHR_materials_pbrSpecularGlossiness": look}}]
    file = gltf(tmp_path_factory.mktemp("g"), materials=materials)
    skin = read_model(file, most_px=64).skins[0]
    assert skin.roughness == pytest.approx(1 - glossiness)
    assert (skin.base_colour <= np.maximum(diffuse, specular) + 1e-12).all()
    if max(specular) <= 0.25 or max(diffuse) >= 0.04:  # no metal
        assert (skin.metallic, tuple(skin.base_colour)) == (0.0, diffuse)
    else:
        assert (skin.metallic, tuple(skin.base_colour)) == (1.0, specular)


def test_metalness_of_a_texture_counts(tmp_path: Path) -> None:
    """Exporters leave the factor at 1 and paint 0 for what is no metal."""
    pbr = {"metallicRoughnessTexture": {"index": 0}}
    images = [{"uri": png_uri(np.tile(np.array([0, 102, 0], np.uint8), (4, 4, 1)))}]
    skin = read_model(
        gltf(tmp_path, materials=[{"pbrMetallicRoughness": pbr}], images=images), most_px=64
    ).skins[0]
    assert (skin.metallic, skin.roughness) == (0.0, pytest.approx(0.4))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"extensionsUsed": ["KHR_materials_clearcoat"]}, "lacquer"),
        ({"extensionsUsed": ["ACME_fur"]}, "ACME_fur is not carried out"),
        ({"animations": [{}]}, "animations are not played"),
        (
            {
                "materials": [
                    {
                        "name": "haze",
                        "alphaMode": "BLEND",
                        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
                    }
                ]
            },
            "haze: alphaMode BLEND",
        ),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 1}]}]}, "1 sets of lines"),
    ],
)
def test_what_is_not_carried_out_is_said_once_with_its_effect(
    more: dict[str, object], said: str, tmp_path: Path
) -> None:
    notes = read_model(gltf(tmp_path, **more), most_px=64).notes
    assert sum(said in note for note in notes) == 1


def test_a_plain_file_has_nothing_to_be_said(tmp_path: Path) -> None:
    assert read_model(gltf(tmp_path), most_px=64).notes == ()


def test_an_extension_that_is_needed_and_unknown_is_a_fault(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"(?s)needs ACME_mesh, .*Export it without"):
        read_model(gltf(tmp_path, extensionsRequired=["ACME_mesh"]), most_px=64)


def test_glass_is_left_out_and_told(tmp_path: Path) -> None:
    materials = [
        {
            "name": "pane",
            "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.8, 0.2, 1]},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}},
        },
        {"name": "wall"},
    ]
    part = {"attributes": {"POSITION": 0}, "indices": 2}
    meshes = [{"primitives": [{**part, "material": 0}, {**part, "material": 1}]}]
    nodes = [{"mesh": 0, "scale": [5, 5, 5]}]
    file = gltf(tmp_path, materials=materials, meshes=meshes, nodes=nodes)
    model = read_world(file, up="auto", metres_per_unit=1.0, leave_out=(), most_px=64).model
    assert len(model.surfaces) == 1
    assert "pane: glass does not tint the light that passes" in model.notes
    assert [note for note in model.notes if "pane: clear surfaces are left out" in note]


names = st.tuples(
    st.sampled_from("abcXYZ"),
    st.text("abcXYZ0123456789_-.", max_size=15),
    st.sampled_from(["", " 2", " of a-b"]),
).map("".join)
numbers = st.floats(-9, 9).map(lambda value: f"{value:.3f}")


@given(
    name=names,
    options=st.lists(
        st.one_of(
            st.tuples(st.sampled_from(["-s", "-o", "-t"]), st.lists(numbers, min_size=1, max_size=3)),
            st.tuples(st.sampled_from(["-clamp", "-cc", "-blendu"]), st.just(["on"])),
            st.tuples(st.sampled_from(["-bm", "-boost", "-texres"]), numbers.map(lambda value: [value])),
            st.tuples(st.just("-mm"), st.lists(numbers, min_size=2, max_size=2)),
        ),
        max_size=5,
        unique_by=lambda option: option[0],
    ),
)
def test_any_options_leave_the_name_of_the_picture(name: str, options: list[tuple[str, list[str]]]) -> None:
    written = " ".join(word for option, values in options for word in (option, *values))
    found, picture = split_options(f"{written} {name}")
    assert picture == name
    assert found == dict(options)


def test_opacity_of_materials_is_read_from_either_statement() -> None:
    text = "newmtl a\nd 0.3\nnewmtl b\nTr 0.7\nnewmtl c\nd -halo 0.3\nnewmtl wall\nKd 1 1 1\n"
    materials = read_library({"": text}).materials
    assert [materials[name].opacity for name in "abc"] == pytest.approx([0.3] * 3)
    assert materials["wall"].opacity == 1
    everything = read_library({"": "newmtl a\nTr 1\nnewmtl b\nTr 1\n"})
    assert everything.materials["a"].opacity == 1
    assert "taken as all opaque" in everything.notes[0]


def test_glass_of_an_obj_is_left_out_and_its_options_move_its_texture(tmp_path: Path) -> None:
    points = [f"v {5 * x} {5 * y} {z}" for z in (0, 2) for x, y, _ in SQUARE]
    corners = ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    faces = ["usemtl floor", "f 1/1 2/2 3/3 4/4", "usemtl glass", "f 5/1 6/2 7/3 8/4", "l 1 2"]
    lines = ["mtllib a.mtl", "mtllib b.mtl", *points, *corners, *faces]
    (tmp_path / "room.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "a.mtl").write_text(
        "newmtl floor\nmap_Kd -s 2 3 1 -o 0.5 0 0 -bm 0.2 my floor.png\nbump x.png\n"
    )
    (tmp_path / "b.mtl").write_text("newmtl glass\nKd 1 1 1\nTr 0.9\n")
    from PIL import Image

    Image.new("RGB", (4, 4), (9, 99, 9)).save(tmp_path / "my floor.png")
    read = read_world(tmp_path / "room.obj", up="z", metres_per_unit=1.0, leave_out=(), most_px=64)
    (floor,) = read.model.surfaces
    assert floor.uv is not None
    assert sorted(map(tuple, floor.uv.tolist())) == [(0.5, 0), (0.5, 3), (2.5, 0), (2.5, 3)]
    told = " ".join(read.model.notes)
    assert "lines and points" in told
    assert "surfaces are smooth" in told
    assert "clear surfaces are left out" in told


def test_collision_hulls_are_left_out_and_told(tmp_path: Path) -> None:
    points = [f"v {5 * x} {5 * y} {z}" for z in (0, 2) for x, y, _ in SQUARE]
    lines = [*points, "o floor", "f 1 2 3 4", "o UCX_floor_00", "f 5 6 7 8"]
    (tmp_path / "room.obj").write_text("\n".join(lines) + "\n")
    model = read_world(tmp_path / "room.obj", up="z", metres_per_unit=1.0, leave_out=(), most_px=64).model
    assert [surface.path for surface in model.surfaces] == [("floor",)]
    assert model.notes == ("UCX_floor_00: collision hulls (UBX_, UCP_, USP_, UCX_) are left out",)


@given(share=st.floats(0.01, 0.99), blended=st.booleans())
def test_clear_surfaces_of_any_share_are_told_once(
    tmp_path_factory: pytest.TempPathFactory, share: float, blended: bool
) -> None:
    """By transmission or by opacity: left out from half clear on, else drawn opaque."""
    look = (
        {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1 - share]}}
        if blended
        else {"extensions": {"KHR_materials_transmission": {"transmissionFactor": share}}}
    )
    file = gltf(tmp_path_factory.mktemp("g"), materials=[{"name": "pane", **look}])
    model = without_clear(read_model(file, most_px=64))
    assert len(model.notes) == 1
    said = (
        "pane: clear surfaces are left out" if share > 0.5 else "pane: half clear surfaces are drawn opaque"
    )
    assert model.notes[0].startswith(said)
    assert len(model.surfaces) == (share <= 0.5)
    opaque = without_clear(read_model(file, most_px=64), solid=True)
    assert len(opaque.surfaces) == 1
    assert "drawn opaque" in opaque.notes[0]


def test_unlit_materials_keep_what_was_photographed(tmp_path: Path) -> None:
    look = {"emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_unlit": {}}}
    model = read_model(gltf(tmp_path, materials=[look], extensionsUsed=["KHR_materials_unlit"]), most_px=64)
    assert model.notes == ()
    assert model.skins[0].unlit
    assert not model.skins[0].emission.any()


@given(
    key=st.sampled_from(["map_Pr", "map_Pm", "map_Ps", "aniso", "Tf", "map_ao", "Pc"]),
    option=st.sampled_from(["-colorspace", "-foo", "-imfchan"]),
    name=names,
)
def test_no_statement_or_option_of_a_library_is_dropped_without_a_word(
    key: str, option: str, name: str
) -> None:
    text = f"newmtl wall\nKd 1 1 1\n{key} 0.5\nmap_Kd {option} sRGB {name}\n"
    library = read_library({"": text})
    assert library.materials["wall"].picture == name
    assert sum(key.lower() in note.lower() for note in library.notes) == 1
    assert sum(option in note for note in library.notes) == (option != "-colorspace")


def test_metals_of_a_library_are_metals() -> None:
    material = read_library({"": "newmtl tap\nKd 1 1 1\nPr 0.2\nPm 1\n"}).materials["tap"]
    assert (material.roughness, material.metallic) == (0.2, 1.0)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.glb", b"", "it is empty"),
        ("a.glb", b"<!DOCTYPE html><html>404</html>", "a web page"),
        ("a.glb", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "git lfs pull"),
        ("a.obj", b"v 0 0 0\n\0\0", "is no text"),
        ("a.glb", b"PK\x03\x04\x14\0\xc3\x28", "(?s)is a ZIP archive.*Unpack it"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\n", "a cloud of 2 points"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "(?s)names item 9 of 3.*keeps to its format"),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
            "a cloud of 1 points",
        ),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex 3\nproperty ushort red\nelement face 1\n"
            b"property list uchar int vertex_indices\nend_header\n0\n0\n0\n3 0 1 2\n",
            "vertices have no x, y, z",
        ),
    ],
)
def test_what_is_no_such_file_is_said_to_be_what_it_is(
    name: str, content: bytes, said: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UserError, match=said):
        read_model(tmp_path / name, most_px=64)


def test_names_in_latin_1_are_read(tmp_path: Path) -> None:
    lines = ["o B\u00fcro", *(f"v {x} {y} {z}" for x, y, z in SQUARE), "f 1 2 3 4"]
    (tmp_path / "room.obj").write_bytes("\n".join(lines).encode("latin-1"))
    model = read_model(tmp_path / "room.obj", most_px=64)
    assert model.surfaces[0].path == ("B\u00fcro",)
    assert model.notes == ("names are not in UTF-8, and are read as Windows-1252",)


def test_a_world_of_glass_alone_is_refused(tmp_path: Path) -> None:
    clear = {"baseColorFactor": [1, 1, 1, 0]}
    file = gltf(tmp_path, materials=[{"alphaMode": "MASK", "pbrMetallicRoughness": clear}])
    with pytest.raises(UserError, match="no triangles"):
        read_world(file, up="auto", metres_per_unit=9.0, leave_out=(), most_px=64)


@pytest.mark.parametrize("size", [1e5, 1e9, np.inf, np.nan])
def test_texture_coordinates_beyond_reason_take_neither_time_nor_memory(size: float) -> None:
    mask = np.tile(np.array([255, 255, 255, 0], np.uint8), (4, 1))
    for clamped in (False, True):
        uv = np.where(SQUARE[:, :2] > 0, size, 0.0)
        model = square(uv, mask=mask, clamped=(clamped, clamped))
        assert len(cut_out(model).surfaces[0].triangles) < 100
