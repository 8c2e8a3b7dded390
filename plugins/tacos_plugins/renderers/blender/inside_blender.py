"""Builds a scene in Blender and takes its pictures. Run in a process of its own, as bpy owns global state.

Usage: python inside_blender.py FOLDER, with what `scene_file` writes in it, and ``shots.json``. Writes
``picture_N.npy``. It imports nothing of this package, so that any Python with bpy can run it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

_FAR_M = 1e5
_SENSOR_MM = 36.0


def main(folder: Path) -> None:
    """Take every picture of a folder."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    description = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    job = json.loads((folder / "shots.json").read_text(encoding="utf-8"))
    with np.load(folder / "scene.npz") as arrays:
        owned = _build(description, arrays)
    scene = bpy.context.scene
    _set_up_cycles(scene, job)
    eye = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(eye)
    scene.camera = eye
    for number, shot in enumerate(job["shots"]):
        np.save(folder / f"picture_{number}.npy", _take(scene, eye, owned, shot, job["near_m"], folder))


def _set_up_cycles(scene: Any, job: dict[str, Any]) -> None:
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = bool(job["denoise"])
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.blur_glossy = 0.0
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces"):
        setattr(cycles, name, job["max_depth"] - 1)
    scene.render.resolution_percentage = 100
    scene.render.use_motion_blur = False
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.render.use_persistent_data = True
    scene.render.dither_intensity = 0.0
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGB"


def _take(
    scene: Any, eye: Any, owned: dict[int, list[Any]], shot: dict[str, Any], near_m: float, folder: Path
) -> np.ndarray:
    """(H, W, 3) float32 luminance, row 0 on top."""
    width, height = shot["width"], shot["height"]
    scene.render.resolution_x, scene.render.resolution_y = width, height
    lens = eye.data
    lens.sensor_fit, lens.sensor_width = "HORIZONTAL", _SENSOR_MM
    lens.lens = shot["focal_px"] * _SENSOR_MM / width
    lens.shift_x = ((width - 1) / 2 - shot["centre_px"][0]) / width
    lens.shift_y = (shot["centre_px"][1] - (height - 1) / 2) / width
    lens.clip_start, lens.clip_end = near_m, _FAR_M
    # Blender's cameras look along -z with y up; ours along z with y down.
    eye.matrix_world = _matrix(np.array(shot["pose"]) @ np.diag([1.0, -1, -1, 1]))
    for thing, parts in owned.items():
        for part in parts:
            part.matrix_world = _matrix(np.array(shot["moved"].get(str(thing), np.eye(4))))
    scene.cycles.samples, scene.cycles.seed = shot["samples"], shot["seed"]
    target = folder / "picture.exr"
    scene.render.filepath = str(target)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(target))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    channels = image.channels
    bpy.data.images.remove(image)
    return np.ascontiguousarray(pixels.reshape(height, width, channels)[::-1, :, :3])


def _build(description: dict[str, Any], arrays: Any) -> dict[int, list[Any]]:
    """Everything but the camera; Blender's objects by object of the world."""
    materials = [_material(index, each, arrays) for index, each in enumerate(description["materials"])]
    owned: dict[int, list[Any]] = {}
    for index, part in enumerate(description["parts"]):
        mesh = _mesh(f"part_{index}", arrays[f"vertices_{index}"], arrays[f"triangles_{index}"])
        layer = mesh.uv_layers.new(name="uv")
        layer.data.foreach_set("uv", arrays[f"uv_{index}"][arrays[f"triangles_{index}"].ravel()].ravel())
        mesh.normals_split_custom_set_from_vertices(arrays[f"normals_{index}"])
        mesh.materials.append(materials[part["material"]])
        owned.setdefault(part["object"], []).append(_placed(mesh))
    for index, light in enumerate(description["lights"]):
        _light(index, light)
    _surroundings(description["ambient"], arrays.get("sky", None))
    return owned


def _mesh(name: str, vertices: np.ndarray, triangles: np.ndarray) -> Any:
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(triangles), 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    return mesh


def _placed(mesh: Any) -> Any:
    thing = bpy.data.objects.new(mesh.name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def _material(index: int, given: dict[str, Any], arrays: Any) -> Any:
    made = bpy.data.materials.new(f"material_{index}")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*given["colour"], 1)
    shader.inputs["Roughness"].default_value = given["roughness"]
    shader.inputs["Metallic"].default_value = given["metallic"]
    shader.inputs["IOR"].default_value = 1.5
    shader.inputs["Specular IOR Level"].default_value = 0.5 * given["coat"]
    if (texture := f"texture_{index}") in arrays:
        links.new(_image(nodes, texture, arrays[texture]).outputs["Color"], shader.inputs["Base Color"])
    if (bumps := f"bumps_{index}") in arrays:
        bend = nodes.new("ShaderNodeNormalMap")
        links.new(_image(nodes, bumps, arrays[bumps]).outputs["Color"], bend.inputs["Color"])
        links.new(bend.outputs["Normal"], shader.inputs["Normal"])
    strongest = max(given["emission"])
    if strongest > 0:
        shader.inputs["Emission Color"].default_value = (*(c / strongest for c in given["emission"]), 1)
        _shine_from_the_front(made, shader.inputs["Emission Strength"], strongest)
    return made


def _shine_from_the_front(made: Any, strength: Any, value: float) -> None:
    """A strength of emission that is zero on the backs of surfaces."""
    nodes, links = made.node_tree.nodes, made.node_tree.links
    side, only, times = (nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "Math", "Math"))
    only.operation, only.inputs[0].default_value = "SUBTRACT", 1.0
    links.new(side.outputs["Backfacing"], only.inputs[1])
    times.operation, times.inputs[1].default_value = "MULTIPLY", value
    links.new(only.outputs[0], times.inputs[0])
    links.new(times.outputs[0], strength)


def _image(nodes: Any, name: str, values: np.ndarray) -> Any:
    node = nodes.new("ShaderNodeTexImage")
    node.image = _pixels(name, values)
    return node


def _pixels(name: str, values: np.ndarray) -> Any:
    """Linear values, row 0 at the bottom."""
    height, width = values.shape[:2]
    image = bpy.data.images.new(name, width, height, float_buffer=True, is_data=True)
    full = np.ones((height, width, 4), np.float32)
    full[..., :3] = values
    image.pixels.foreach_set(full.ravel())
    image.update()
    return image


def _light(index: int, light: dict[str, Any]) -> None:
    if light["kind"] == "sun":
        strongest = max(light["lux"])
        star = bpy.data.lights.new(f"light_{index}", "SUN")
        star.energy, star.angle = strongest, light["angle"]
        star.color = [c / strongest for c in light["lux"]]
        placed = bpy.data.objects.new(star.name, star)
        bpy.context.scene.collection.objects.link(placed)
        placed.matrix_world = _matrix(_looking_along(-np.array(light["towards"])))
        return
    if light["kind"] == "square":
        mesh = _mesh(f"light_{index}", np.array(light["corners"]), np.array([[0, 1, 2], [0, 2, 3]]))
        scale = 1.0
    else:
        vertices, triangles = _ball(light["radius"])
        corners = vertices[triangles]
        area = (
            np.linalg.norm(
                np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
            ).sum()
            / 2
        )
        scale = 4 * np.pi * light["radius"] ** 2 / area  # its facets have less area than the sphere
        mesh = _mesh(f"light_{index}", vertices + np.array(light["at"]), triangles)
    mesh.materials.append(_glow(f"light_{index}", scale * np.array(light["luminance"])))
    _placed(mesh).visible_camera = False  # renderer.moderngl draws no lights either


def _glow(name: str, luminance: np.ndarray) -> Any:
    """Emission from the front alone."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    front, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    strongest = float(luminance.max())
    front.inputs["Color"].default_value = (*(luminance / strongest), 1)
    _shine_from_the_front(made, front.inputs["Strength"], strongest)
    links.new(front.outputs[0], out.inputs["Surface"])
    return made


def _ball(radius: float, rings: int = 12, sectors: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """A sphere about the origin, facing outwards."""
    tilt = np.linspace(0, np.pi, rings + 1)[:, None]
    turn = np.arange(sectors)[None] / sectors * 2 * np.pi
    points = np.stack(
        [np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt) + 0 * turn], axis=-1
    )
    row, column = np.meshgrid(np.arange(rings), np.arange(sectors), indexing="ij")
    a, b = row * sectors + column, row * sectors + (column + 1) % sectors
    faces = np.concatenate([np.stack([a, a + sectors, b + sectors], -1), np.stack([a, b + sectors, b], -1)])
    triangles = faces.reshape(-1, 3)
    vertices = radius * points.reshape(-1, 3)
    corners = vertices[triangles]
    extent = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return vertices, triangles[extent > 1e-12 * radius**2]


def _surroundings(ambient: list[float], sky: np.ndarray | None) -> None:
    world = bpy.data.worlds.new("surroundings")
    bpy.context.scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1.0
    background.inputs["Color"].default_value = (*ambient, 1)
    if sky is not None:
        # A world's columns run from +x by way of +y; Blender's have +x in the middle and run the other way.
        turned = np.roll(sky, -sky.shape[1] // 2, axis=1)[::-1, ::-1]
        node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        node.image = _pixels("sky", np.ascontiguousarray(turned))
        world.node_tree.links.new(node.outputs["Color"], background.inputs["Color"])


def _looking_along(direction: np.ndarray) -> np.ndarray:
    """(4, 4) whose -z axis lies along a unit vector."""
    z = -direction
    helper = np.array([1.0, 0, 0]) if abs(z[0]) < 0.9 else np.array([0, 1.0, 0])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return matrix


def _matrix(values: np.ndarray) -> Any:
    from mathutils import Matrix

    return Matrix(values.tolist())


if __name__ == "__main__":
    main(Path(sys.argv[1]))
