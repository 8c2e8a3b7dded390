"""Settings of a world from a file: where it is, what things in it are, and how it is walked in."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tacos_framework import setting
from tacos_worlds.kit.carried import CarriedSettings

Metres = Annotated[float, Field(gt=0)]
Seconds = Annotated[float, Field(gt=0)]
Waypoint = Annotated[tuple[float, ...], Field(min_length=2, max_length=3)]


class ImportedSettings(CarriedSettings):
    file: str = setting(help="The world: a .glb, .gltf, .obj, .ply or .stl file.", is_path=True)
    labels: str = setting(
        "",
        help="Table of classes: CSV with the columns pattern and class, or YAML with pattern: class. "
        "Patterns, with * and ?, are those of node names.",
        is_path=True,
    )
    obstacles: tuple[str, ...] = setting(
        ("threshold",), help="Classes of things that are stepped on and should be seen before."
    )
    leave_out: tuple[str, ...] = setting(
        (), help="Patterns of names of nodes that are not to be there, such as closed doors."
    )
    glass: Literal["clear", "solid"] = setting(
        "clear",
        help="Panes that are mostly clear: left out, so that depth is that of what lies behind (clear), or "
        "drawn opaque, so that depth and ids are theirs (solid).",
    )
    up: Literal["auto", "x", "y", "z"] = setting(
        "auto", help="Axis of the file that points up: y in glTF; else auto takes that of the floors."
    )
    metres_per_unit: float = setting(1.0, help="Metres for one unit of the file, 1 in glTF.", unit="m", gt=0)
    light: Literal["auto", "file", "lamps", "both"] = setting(
        "auto",
        help="Light: the file's lights and glowing surfaces and the sky (file), lamps placed under "
        "ceilings (lamps), both, or lamps only where nothing else does (auto).",
    )
    level: Literal["scenario", "file"] = setting(
        "scenario",
        help="Level of light: scaled to the scenario's illuminance, or that of the file (file).",
    )
    emission_cd_m2: float = setting(
        1.0, help="Luminance for one unit of emission in the file, 1 in glTF.", unit="cd/m2", gt=0
    )
    sky: str = setting(
        "",
        help="Panorama around the world (.hdr, .exr), zenith on top; its sun casts shadows.",
        is_path=True,
    )
    sky_turn_deg: float = setting(
        0.0, help="Turns the panorama to the left about the vertical.", unit="deg", ge=-360, le=360
    )
    sky_lux: float | None = setting(
        None,
        help="Illuminance of the panorama with its sun on open, level ground; as in its file where not "
        "given. Weighs it against the file's lights.",
        unit="lux",
        gt=0,
    )
    path: str = setting(
        "",
        help="Recorded poses in the world of the file: TUM, EuRoC, KITTI, COLMAP, NeRF, or a table with "
        "names; else ways are found on the floor.",
        is_path=True,
    )
    path_of: Literal["camera", "agent"] = setting(
        "camera",
        help="Body of the recorded poses: a camera (x right, y down, z ahead) or an agent "
        "(x ahead, y left, z up).",
    )
    path_axes: Literal["file", "world"] = setting(
        "file", help="Axes of the recorded positions: those of the file, or metres with z up (world)."
    )
    waypoints_m: tuple[Waypoint, ...] = setting(
        (), help="Places to walk by, (x, y) or (x, y, z) with z up; else tours are drawn.", unit="m"
    )
    ground: Literal["auto", "inside", "outside"] = setting(
        "auto", help="Ground to walk on: under a ceiling, or in the open; auto prefers a ceiling."
    )
    start_m: Waypoint | None = setting(
        None, help="A place on the floor to walk on, (x, y) or (x, y, z) with z up.", unit="m"
    )
    size_m: tuple[Metres, Metres] | None = setting(
        None,
        help="Largest extent of the floor a tour covers along x and y; all of it by default.",
        unit="m",
    )
    radius_m: float = setting(
        0.25, help="The agent's middle stays this far from things.", unit="m", gt=0, le=3
    )
    height_m: float = setting(1.8, help="Room the agent needs above the floor.", unit="m", gt=0, le=10)
    step_m: float = setting(
        0.25, help="Greatest step up or down; higher things are walked around.", unit="m", ge=0.01, le=1
    )
    frames: int = setting(500, help="Frames taken in all.", ge=1, le=1_000_000, also=("steps",))
    sampling: Literal["walk", "approaches"] = setting(
        "walk", help="Places of the frames: all along the way, or only before obstacles."
    )
    frame_rate_hz: float = setting(
        5.0, help="Frames per second of walking, under sampling: walk.", unit="Hz", gt=0, also=("fps",)
    )
    before_step_s: tuple[Seconds, ...] = setting(
        (1.6, 1.4, 0.8, 0.6),
        help="Times before an obstacle is stepped on, falling, under sampling: approaches.",
        unit="s",
        min_length=1,
    )
    speed_m_s: float = setting(1.0, help="Speed on straight ways.", unit="m/s", gt=0, le=50)
    camera_height_m: tuple[Metres, Metres] = setting(
        (1.0, 2.0), help="Range from which each walk draws the height of the agent's eye.", unit="m"
    )
    triangles: int = setting(
        200_000, help="Triangles kept; far surfaces lose theirs first.", ge=100, le=20_000_000
    )
    texture_memory_mb: float = setting(
        512.0, help="Memory for all textures together, which decides how large they are.", unit="MB", gt=1
    )

    @model_validator(mode="after")
    def _fits(self) -> ImportedSettings:
        low, high = self.camera_height_m
        if low > high:
            raise ValueError(f"camera_height_m must rise from low to high, not {self.camera_height_m}")
        if any(later >= earlier for earlier, later in pairwise(self.before_step_s)):
            raise ValueError(f"before_step_s must fall from time to time, not {self.before_step_s}")
        if self.path and self.waypoints_m:
            raise ValueError("path and waypoints_m exclude each other: give one of the two")
        if len(self.waypoints_m) == 1:
            raise ValueError("waypoints_m names one place, but a way needs two")
        if self.path and self.sampling == "approaches":
            raise ValueError("frames of a recorded path are taken all along it: give sampling: walk")
        return self
