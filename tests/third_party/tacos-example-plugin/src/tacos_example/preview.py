"""A contact sheet of what a scene looks like."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from tacos_framework import (
    Camera,
    Exposure,
    Plugins,
    Rig,
    Settings,
    Use,
    UserError,
    check,
    setting,
    signature_of,
)
from tacos_framework.camera import agent_from_camera, display_image

PIXEL_UM = 3.0


class Preview:
    """Renders a few frames of an episode and puts them side by side into ``preview.png``.

    White is the luminance that 99 % of the pixels stay below.
    """

    class Config(Settings):
        scene: Use = setting(help="Scene to look at.")
        renderer: Use = setting(Use(use="renderer.moderngl"), help="Its renderer.")
        illumination_lux: float = setting(20.0, help="Light of the scene.", unit="lux", gt=0)
        hfov_deg: float = setting(90.0, help="Field of view of the camera.", unit="deg", gt=0, lt=180)
        width_px: int = setting(320, help="Width of a picture.", unit="px", ge=16)
        pictures: int = setting(4, help="Pictures, from the beginning to the end of the walk.", ge=1)

    def __init__(self, config: Config) -> None:
        self.config = config

    def run(self, *, out: Path, seed: int, plugins: Plugins, progress: Any) -> Mapping[str, Any]:
        """Render; returns how many frames the episode has, and where the sheet lies."""
        scene = build(plugins, self.config.scene, "scene")
        renderer = build(plugins, self.config.renderer, "renderer")
        rng, lux = np.random.default_rng(seed), self.config.illumination_lux
        episode = scene.episode(**asked_for(scene, "scene", rng=rng, illumination_lux=lux))
        count = min(self.config.pictures, len(episode))
        keywords = asked_for(renderer, "renderer", rig=self._rig(), exposure=Exposure())
        progress.phase("Rendering", count)
        pictures = []
        for frame in np.linspace(0, len(episode) - 1, count).astype(int):
            capture = renderer.capture(episode[frame : frame + 1], **keywords)
            pictures.append(capture.views[0].luminance_cd_m2[0])
            progress.step(f"frame {frame}")
        sheet = out / "preview.png"
        cv2.imwrite(str(sheet), contact_sheet(pictures)[..., ::-1])
        return {"frames": len(episode), "pictures": count, "summary": f"{count} pictures: {sheet}"}

    def _rig(self) -> Rig:
        width_px, height_px = self.config.width_px, self.config.width_px * 3 // 4
        half_width_mm = width_px * PIXEL_UM * 1e-3 / 2
        focal_length_mm = half_width_mm / math.tan(math.radians(self.config.hfov_deg / 2))
        ahead = agent_from_camera((0.0, 0.0, 0.0), pitch_deg=0.0)
        return Rig((Camera("preview", width_px, height_px, PIXEL_UM, focal_length_mm, ahead),))


def build(plugins: Plugins, use: Use, kind: str) -> Any:
    """The component a recipe names, with its settings checked."""
    cls = plugins.resolve(use.use, kind)
    config, faults, _ = check(cls.Config, use.settings, lambda path: f"{kind}.{'.'.join(map(str, path))}")
    if faults:
        raise UserError(faults)
    return cls(config)


def asked_for(component: Any, kind: str, **offered: Any) -> dict[str, Any]:
    """Of what is offered, the keywords the component's verb asks for."""
    wanted = signature_of(type(component), kind).supplied
    return {name: value for name, value in offered.items() if name in wanted}


def contact_sheet(pictures: list[NDArray[np.float32]]) -> NDArray[np.uint8]:
    """(H, N W, 3) uint8 of linear (H, W, 3) pictures side by side."""
    row = np.concatenate(pictures, axis=1)
    return display_image(row, 0.0, max(float(np.quantile(row, 0.99)), 1e-9))
