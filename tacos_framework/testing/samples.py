"""Small inputs for components: a corner of a room, a rig, an episode, a capture, frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tacos_framework.camera.geometry import agent_from_camera, world_from_camera
from tacos_framework.formation.arrays import digitise
from tacos_framework.values import (
    Camera,
    Capture,
    Crossing,
    Episode,
    Exposure,
    FrameBatch,
    Light,
    Material,
    MeshPart,
    Object,
    Rig,
    Trajectory,
    View,
    World,
)

WALL_X_M = 4.0
"""The wall fills the plane x = 4 m; the agent looks at it from x = 0."""
SIGN_ID = 1
"""Object id of the sign, a square that stands in front of the wall."""
SIGN_CENTRE_M = (3.0, 0.4, 1.6)
EYE_HEIGHT_M = 1.5
FRAME_INTERVAL_S = 0.1
SPEED_M_S = 0.5
BLOCK_PX = 8
"""Size of the blocks the moving card is made of."""


def sample_rig(*names: str, width_px: int = 64, height_px: int = 48) -> Rig:
    """Level cameras 0.1 m apart, 90 degrees wide; one called ``camera`` unless names are given."""
    names = names or ("camera",)
    pixel_um = 3.0
    return Rig(
        tuple(
            Camera(
                name,
                width_px=width_px,
                height_px=height_px,
                pixel_um=pixel_um,
                focal_length_mm=width_px / 2 * pixel_um * 1e-3,
                agent_from_camera=agent_from_camera((0.0, 0.1 * -i, 0.0), pitch_deg=0.0),
            )
            for i, name in enumerate(names)
        )
    )


def sample_exposure(**changes: float) -> Exposure:
    """30 ms at f/2 and 5 dB, or as changed."""
    return Exposure(**{"time_s": 0.030, "f_number": 2.0, "gain_db": 5.0, **changes})


def sample_world(brightness: float = 1.0) -> World:
    """A floor, a wall and a sign under one panel, in grey.

    `brightness`: factor on all light [1].
    """
    grey = Material("grey", base_colour=np.full(3, 0.5, np.float32))
    dark = Material("dark", base_colour=np.full(3, 0.1, np.float32))
    x, y, z = SIGN_CENTRE_M
    return World(
        key=f"tacos_framework.testing.sample_world({brightness!r})",
        parts=(
            _rectangle((1.5, 0.0, 0.0), (2.5, 0.0, 0.0), (0.0, 4.0, 0.0), material=0, object_id=0),
            _rectangle((WALL_X_M, 0.0, 1.5), (0.0, 0.0, 1.5), (0.0, 4.0, 0.0), material=0, object_id=0),
            _rectangle((x, y, z), (0.0, 0.0, 0.2), (0.0, 0.2, 0.0), material=1, object_id=SIGN_ID),
        ),
        materials=(grey, dark),
        objects=(Object("background", "background"), Object("sign", "sign")),
        class_names=("background", "sign"),
        lights=(
            Light(
                position_m=np.array([1.0, 0.0, 2.9], np.float32),
                flux_lm=np.full(3, 1000.0 * brightness, np.float32),
                normal=np.array([0.0, 0.0, -1.0], np.float32),
                half_u_m=np.array([0.5, 0.0, 0.0], np.float32),
                half_v_m=np.array([0.0, 0.5, 0.0], np.float32),
            ),
        ),
        ambient_cd_m2=np.full(3, 0.5 * brightness, np.float32),
    )


def sample_episode(frames: int = 6, brightness: float = 1.0) -> Episode:
    """One walk straight at the wall at 0.5 m/s, ten frames a second, stepping on the sign at its end."""
    time_s = np.arange(frames, dtype=np.float64) * FRAME_INTERVAL_S
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, 2, 3] = EYE_HEIGHT_M
    end_s = max(frames, 1) * FRAME_INTERVAL_S
    poses[1, 0, 3] = SPEED_M_S * end_s
    return Episode(
        world=sample_world(brightness),
        trajectory=Trajectory(np.array([0.0, end_s]), poses),
        time_s=time_s,
        walk=np.zeros(frames, np.int32),
        crossings=(Crossing(SIGN_ID, float(time_s[-1]) - FRAME_INTERVAL_S / 2),) if frames > 1 else (),
    )


def sample_capture(
    rig: Rig | None = None, frames: int = 6, *, luminance_cd_m2: float = 3.0, shift_px: int = 2
) -> Capture:
    """A textured card that moves sideways, the sign on it, made without any renderer.

    `luminance_cd_m2`: mean luminance [cd/m2]. `shift_px`: motion of the card from frame to frame [px].
    """
    rig = rig or sample_rig()
    episode = sample_episode(frames)
    poses = episode.trajectory.at(episode.time_s)
    return Capture(episode, tuple(_card(camera, poses, luminance_cd_m2, shift_px) for camera in rig.cameras))


def part_of(capture: Capture, start: int, stop: int | None) -> Capture:
    run = slice(start, stop)
    names = ("world_from_camera", "luminance_cd_m2", "depth_m", "object_id")
    views = (replace(v, **{name: getattr(v, name)[run] for name in names}) for v in capture.views)
    return replace(capture, episode=capture.episode[run], views=tuple(views))


def sample_frames(rig: Rig | None = None, frames: int = 6) -> FrameBatch:
    """Frames of `sample_capture` at 8 bits without noise, mid grey on average."""
    capture = sample_capture(rig, frames, luminance_cd_m2=100.0)
    return FrameBatch(capture, tuple(digitise(view.luminance_cd_m2, 255) for view in capture.views))


def sample_expected_dn(rig: Rig | None = None, frames: int = 6) -> NDArray[np.float32]:
    """(N, H, W, 3) expected samples of the first camera of `sample_capture`: 8 bits, a pedestal of 16 DN."""
    view = sample_capture(rig, frames, luminance_cd_m2=100.0).views[0]
    return view.luminance_cd_m2 + np.float32(16)


def _card(camera: Camera, world_from_agent: NDArray[np.float64], mean: float, shift_px: int) -> View:
    frames, height, width = len(world_from_agent), camera.height_px, camera.width_px
    size = (height // BLOCK_PX + 1, (width + frames * shift_px) // BLOCK_PX + 1)
    blocks = np.random.default_rng(5).uniform(0.2, 1.8, size)
    card = np.kron(blocks, np.ones((BLOCK_PX, BLOCK_PX))) * mean
    sign = np.zeros(card.shape, np.int32)
    sign[height // 3 : 2 * height // 3, width // 3 : 2 * width // 3] = SIGN_ID
    windows = [np.s_[:height, i * shift_px : i * shift_px + width] for i in range(frames)]
    light = np.stack([card[window] for window in windows])
    return View(
        camera=camera,
        world_from_camera=world_from_camera(world_from_agent, camera.agent_from_camera),
        luminance_cd_m2=np.repeat(light[..., None], 3, axis=-1).astype(np.float32),
        depth_m=np.full((frames, height, width), 3.0, np.float32),
        object_id=np.stack([sign[window] for window in windows]),
    )


def _rectangle(
    centre: tuple[float, ...],
    half_u: tuple[float, ...],
    half_v: tuple[float, ...],
    *,
    material: int,
    object_id: int,
) -> MeshPart:
    """A rectangle that faces ``half_u x half_v``."""
    middle, u, v = (np.array(vector, np.float32) for vector in (centre, half_u, half_v))
    normal = np.cross(u, v)
    corners = [middle - u - v, middle + u - v, middle + u + v, middle - u + v]
    across, along = 2 * np.linalg.norm(u), 2 * np.linalg.norm(v)
    return MeshPart(
        vertices_m=np.array(corners, np.float32),
        normals=np.tile(normal / np.linalg.norm(normal), (4, 1)).astype(np.float32),
        uv_m=np.array([[0, 0], [across, 0], [across, along], [0, along]], np.float32),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        material=material,
        object_id=object_id,
    )
