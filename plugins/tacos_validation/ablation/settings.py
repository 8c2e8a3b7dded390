"""Settings of an ablation."""

from __future__ import annotations

from pydantic import JsonValue

from tacos_framework import Settings, setting
from tacos_validation.rank_agreement.settings import RankedCameras


class AblationConfig(Settings):
    study: str = setting(help="The recipe of the study: a path, or the name of a shipped one.", is_path=True)
    change: dict[str, JsonValue] = setting(
        {}, help="Keys of that recipe to change throughout, as with --set."
    )
    without: dict[str, dict[str, JsonValue]] = setting(
        help="For each step that is left out, by name, the keys that leave it out.", min_length=1
    )
    cameras: RankedCameras = setting(help="The cameras to rank.")
    scenes: int | None = setting(None, help="Scenes to score them on; by default those of the study.", ge=2)
    confidence: float = setting(
        0.95, help="Confidence of the intervals of tau, and of a camera that is not as good.", gt=0, lt=1
    )
    resamples: int = setting(200, help="Draws of scenes behind the intervals of tau.", ge=10)
