"""A house as an engineer would model it in Blender, exported as GLB. Run by a Python that has bpy.

Usage: python blender_house.py house.glb
"""

from __future__ import annotations

import sys

import bpy
import numpy as np

WALL_M, HEIGHT_M, DOOR_M = 0.12, 2.6, 0.95


def material(name, colour, roughness=0.8, emission=0.0, image=None, alpha=1.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Alpha"].default_value = alpha
    if emission:
        shader.inputs["Emission Color"].default_value = (1, 0.93, 0.85, 1)
        shader.inputs["Emission Strength"].default_value = emission
    if alpha < 1:
        made.surface_render_method = "BLENDED"
    if image is not None:
        node = made.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        made.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    return made


def pattern(name, seed, tint, size=256):
    rng = np.random.default_rng(seed)
    fine = rng.normal(0, 0.12, (size, size, 1)) + np.kron(
        rng.normal(0, 0.12, (32, 32, 1)), np.ones((8, 8, 1))
    )
    pixels = np.ones((size, size, 4), np.float32)
    pixels[..., :3] = np.clip(np.array(tint) * (1 + fine), 0, 1)
    image = bpy.data.images.new(name, size, size)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def box(name, lower, upper, skin):
    lower, upper = np.array(lower, float), np.array(upper, float)
    bpy.ops.mesh.primitive_cube_add(size=1, location=tuple((lower + upper) / 2))
    thing = bpy.context.object
    thing.name, thing.scale = name, tuple(upper - lower)
    thing.data.materials.append(skin)
    return thing


def wall_with_door(name, lower, upper, axis, door_at, skin):
    """Two lengths of wall and a lintel; `axis` is the one the wall runs along."""
    for part, (start, end, foot) in {
        "a": (lower[axis], door_at - DOOR_M / 2, 0.0),
        "b": (door_at + DOOR_M / 2, upper[axis], 0.0),
        "lintel": (door_at - DOOR_M / 2, door_at + DOOR_M / 2, 2.05),
    }.items():
        low, high = list(lower), list(upper)
        low[axis], high[axis], low[2] = start, end, foot
        box(f"{name}_{part}", low, high, skin)


def main(target):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    plaster = material("Plaster", (0.8, 0.78, 0.72), image=pattern("plaster", 1, (0.8, 0.78, 0.72)))
    oak = material("Oak", (0.5, 0.33, 0.2), 0.45, image=pattern("oak", 2, (0.5, 0.33, 0.2)))
    cloth = material("Cloth", (0.2, 0.3, 0.5), 0.95, image=pattern("cloth", 3, (0.25, 0.35, 0.55)))
    steel = material("Steel", (0.7, 0.7, 0.72), 0.4)
    white, glass = material("Lacquer", (0.85, 0.85, 0.85), 0.5), material("Glass", (1, 1, 1), 0.1, alpha=0.1)
    glow = material("Panel", (1, 1, 1), emission=2500.0)
    box("Floor", (0, 0, -0.1), (9, 7, 0), oak)
    box("Ceiling", (0, 0, HEIGHT_M), (9, 7, HEIGHT_M + 0.1), plaster)
    box("Wall_south", (0, 0, 0), (9, WALL_M, HEIGHT_M), plaster)
    box("Wall_north", (0, 7 - WALL_M, 0), (9, 7, HEIGHT_M), plaster)
    box("Wall_west", (0, 0, 0), (WALL_M, 7, HEIGHT_M), plaster)
    box("Wall_east_low", (9 - WALL_M, 0, 0), (9, 7, 1.0), plaster)
    box("Wall_east_high", (9 - WALL_M, 0, 2.2), (9, 7, HEIGHT_M), plaster)
    box("Window", (8.93, 0, 1.0), (8.95, 7, 2.2), glass)
    wall_with_door("Partition_x", (4.5, 0.12, 0), (4.62, 6.88, HEIGHT_M), 1, 1.6, plaster)
    wall_with_door("Partition_y", (0.12, 3.6, 0), (4.5, 3.72, HEIGHT_M), 0, 2.4, plaster)
    wall_with_door("Partition_z", (4.62, 3.2, 0), (8.88, 3.32, HEIGHT_M), 0, 6.6, plaster)
    box("threshold_hall", (4.48, 1.15, 0), (4.64, 2.05, 0.02), steel)
    box("threshold_bedroom", (1.95, 3.58, 0), (2.85, 3.74, 0.02), steel)
    sill = box("Strip.003", (6.15, 3.18, 0), (7.05, 3.34, 0.02), steel)
    sill["class"] = "threshold"
    box("Sofa", (0.3, 0.3, 0), (2.3, 1.1, 0.75), cloth)
    box("Bed_frame", (0.3, 4.9, 0), (2.2, 6.7, 0.5), cloth)
    box("SM_Desk_01", (7.6, 4.5, 0.68), (8.7, 6.2, 0.74), oak)
    for number, (x, y) in enumerate(((7.65, 4.55), (8.6, 4.55), (7.65, 6.1), (8.6, 6.1))):
        box(f"Leg_{number}", (x, y, 0), (x + 0.06, y + 0.06, 0.68), steel)
    box("Crate_17", (7.5, 0.4, 0), (8.4, 1.2, 0.9), oak)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.25, location=(5.3, 6.2, 0.25), segments=24, ring_count=12)
    bpy.context.object.name = "Toy_ball"
    bpy.context.object.data.materials.append(white)
    for x, y in ((2.2, 1.8), (2.2, 5.3), (6.6, 1.6), (6.6, 5.2)):
        bpy.ops.mesh.primitive_plane_add(size=0.6, location=(x, y, HEIGHT_M - 0.02), rotation=(np.pi, 0, 0))
        bpy.context.object.name = "Panel"
        bpy.context.object.data.materials.append(glow)
    bulb = bpy.data.lights.new("Bulb", "POINT")
    bulb.energy = 5.0
    holder = bpy.data.objects.new("Bulb", bulb)
    holder.location = (3.6, 6.2, 1.5)
    bpy.context.collection.objects.link(holder)
    bpy.ops.export_scene.gltf(filepath=target, export_lights=True, export_extras=True, export_apply=True)


main(sys.argv[1])
