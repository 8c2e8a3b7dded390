"""Frames of a textured room, cast ray by ray, through which a stereo rig walks on a known path."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from tacos_framework.camera.geometry import agent_from_camera, pixel_rays
from tacos_framework.testing.samples import sample_episode
from tacos_framework.values import Camera, Capture, FrameBatch, Rig, Trajectory, View

HALF_M = np.array([4.0, 3.0, 1.5])
"""The room reaches so far from its middle along x, y and z [m]."""
TEXEL_M = 0.02


def rig(width_px: int = 320, height_px: int = 240, baseline_m: float = 0.2) -> Rig:
    """Two level cameras side by side, 84 degrees wide."""
    return Rig(
        tuple(
            Camera(
                name,
                width_px,
                height_px,
                pixel_um=3.0,
                focal_length_mm=0.55 * width_px * 3e-3,
                agent_from_camera=agent_from_camera((0.0, left_m, 0.0), pitch_deg=-5.0),
            )
            for name, left_m in (("left", baseline_m / 2), ("right", -baseline_m / 2))
        )
    )


def walk(frames: int, *, step_m: float = 0.08, turn_deg: float = 3.0) -> np.ndarray:
    """(N, 4, 4) poses of an agent that walks ahead, turning left, and nods a little."""
    poses = np.tile(np.eye(4), (frames, 1, 1))
    for i in range(frames):
        yaw, pitch = np.radians(turn_deg * i), np.radians(np.sin(i))
        poses[i, :3, :3] = (
            cv2.Rodrigues(np.array([0.0, 0.0, yaw]))[0] @ cv2.Rodrigues(np.array([0.0, pitch, 0.0]))[0]
        )
        poses[i, :3, 3] = (-2.0 + step_m * i, -0.5 + 0.02 * i, 0.1 + 0.01 * np.sin(2 * i))
    return poses


def room_frames(
    poses: np.ndarray, cameras: Rig | None = None, *, noise_dn: float = 1.0, blur_px: float = 0.0
) -> FrameBatch:
    """What the rig sees: 8-bit linear mono images with noise; frames are a tenth of a second apart."""
    cameras = cameras or rig()
    rng = np.random.default_rng(5)
    blots = cv2.GaussianBlur(rng.uniform(0, 255, (512, 512)).astype(np.float32), (0, 0), 2.0)
    texture = np.clip((blots - 127.5) * 5 + 90, 5, 200).astype(np.float32)
    episode = replace(
        sample_episode(len(poses)),
        trajectory=Trajectory(np.arange(len(poses)) * 0.1, poses),
        time_s=np.arange(len(poses)) * 0.1,
        walk=np.zeros(len(poses), np.int32),
    )
    views, images = [], []
    for camera in cameras.cameras:
        seen = poses @ camera.agent_from_camera
        light = np.stack([_cast(camera, pose, texture) for pose in seen])
        if blur_px:
            light = np.stack([cv2.blur(each, (round(blur_px), 1)) for each in light])
        size = light.shape
        views.append(
            View(
                camera,
                seen,
                np.repeat(light[..., None], 3, -1),
                np.ones(size, np.float32),
                np.zeros(size, np.int32),
            )
        )
        noisy = light[..., None] + noise_dn * rng.standard_normal((*size, 1))
        images.append(np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    return FrameBatch(Capture(episode, tuple(views)), tuple(images))


def _cast(camera: Camera, world_from_camera: np.ndarray, texture: np.ndarray) -> np.ndarray:
    rays = pixel_rays(camera) @ world_from_camera[:3, :3].T
    origin = world_from_camera[:3, 3]
    with np.errstate(divide="ignore"):
        reach = np.where(rays > 0, HALF_M - origin, -HALF_M - origin) / rays
    axis = reach.argmin(axis=-1)
    hit = origin + rays * np.take_along_axis(reach, axis[..., None], axis=-1)
    across = np.where(axis == 0, hit[..., 1], hit[..., 0])
    up = np.where(axis == 2, hit[..., 1], hit[..., 2])
    side = np.take_along_axis(rays, axis[..., None], axis=-1)[..., 0] > 0
    shift = 97 * (2 * axis + side)  # each wall shows another part of the texture
    at = [((metres / TEXEL_M + shift) % 512).astype(np.float32) for metres in (across, up)]
    return cv2.remap(texture, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
