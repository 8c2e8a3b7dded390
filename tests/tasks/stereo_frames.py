"""Pairs of frames of textured planes, whose depth is known everywhere."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from tacos_framework.camera.geometry import agent_from_camera
from tacos_framework.testing.samples import sample_episode
from tacos_framework.values import Camera, Capture, FrameBatch, Rig, View

FAR_M, NEAR_M = 12.0, 5.0
TEXEL_M = 0.03
"""Size of the blots on the planes: a few pixels wide in the images."""


def stereo_rig(
    *, width_px: int = 128, height_px: int = 64, baseline_m: float = 0.3, focal_length_px: float = 110.0
) -> Rig:
    """Two level cameras side by side."""
    pixel_um = 3.0
    return Rig(
        tuple(
            Camera(
                name,
                width_px=width_px,
                height_px=height_px,
                pixel_um=pixel_um,
                focal_length_mm=focal_length_px * pixel_um * 1e-3,
                agent_from_camera=agent_from_camera((0.0, left_m, 0.0), pitch_deg=0.0),
            )
            for name, left_m in (("left", baseline_m / 2), ("right", -baseline_m / 2))
        )
    )


def stereo_frames(
    rig: Rig | None = None, frames: int = 4, *, sky_rows: int = 0, seed: int = 0, noise_dn: float = 1.0
) -> FrameBatch:
    """A card before a wall, both textured anew in each frame; rows of sky above them."""
    rig = rig or stereo_rig()
    rng = np.random.default_rng(seed)
    textures = [
        [cv2.GaussianBlur(rng.uniform(0, 255, (512, 512)).astype(np.float32), (0, 0), 1.5) for _ in range(2)]
        for _ in range(frames)
    ]
    episode = sample_episode(frames)
    views, images = [], []
    for camera in rig.cameras:
        shots = [_shot(camera, pair, sky_rows) for pair in textures]
        light = np.stack([shot[0] for shot in shots])
        depth = np.stack([shot[1] for shot in shots])
        poses = episode.trajectory.at(episode.time_s) @ camera.agent_from_camera
        views.append(
            View(camera, poses, np.repeat(light[..., None], 3, -1), depth, np.zeros(depth.shape, np.int32))
        )
        noisy = light[..., None] + noise_dn * rng.standard_normal((*light.shape, 3))
        images.append(np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    return FrameBatch(Capture(episode, tuple(views)), tuple(images))


def _shot(camera, textures, sky_rows: int):
    """Light and depth of one camera: a wall at 12 m, and a card at 5 m in its middle."""
    right_m = -camera.agent_from_camera[1, 3]
    cx, cy = camera.centre_px
    x, y = np.meshgrid(np.arange(camera.width_px) - cx, np.arange(camera.height_px) - cy)
    light, depth = None, None
    for texture, depth_m in zip(textures, (FAR_M, NEAR_M), strict=True):
        across = x * depth_m / camera.focal_length_px + right_m
        down = y * depth_m / camera.focal_length_px
        at = [((m / TEXEL_M / depth_m * NEAR_M + 256) % 512).astype(np.float32) for m in (across, down)]
        seen = cv2.remap(texture, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        contrast = np.clip((seen - 127.5) * 4 + 127.5, 5, 250)
        if light is None:
            light, depth = contrast, np.full(contrast.shape, depth_m, np.float32)
        else:
            card = (np.abs(across) < 0.8) & (np.abs(down) < 0.6)
            light, depth = np.where(card, contrast, light), np.where(card, np.float32(depth_m), depth)
    light[:sky_rows], depth[:sky_rows] = 240, np.inf
    return light.astype(np.float32), depth.astype(np.float32)


def moved(rig: Rig, index: int, **changes) -> Rig:
    """A rig with one camera changed."""
    cameras = list(rig.cameras)
    cameras[index] = replace(cameras[index], **changes)
    return Rig(tuple(cameras))
