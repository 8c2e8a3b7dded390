"""The study a user means: a recipe, a finished run, or a scene by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tacos_framework import (
    Fault,
    Plugins,
    Recipe,
    SceneBase,
    UserError,
    load_recipe,
    optional,
    read_yaml_draft,
    recipe_from,
    to_yaml,
)

INDOORS = {"illumination_lux": 20.0, "gain_db": 5.0, "exposure_ms": 30.0, "f_number": 2.0}
"""A room in the evening, as `headset_quick` has it: a white wall comes out at 200 of 255."""

OUTDOORS = {"illumination_lux": 5000.0, "gain_db": 0.0, "exposure_ms": 3.0, "f_number": 8.0}
"""Daylight, as `stereo_quick` has it, for scenes that a car drives through; the same brightness."""

DUSK_LUX = 100.0
"""With less light outdoors, as at dusk and by night, a camera is set as indoors [lux]."""


def study_recipe(
    what: str | Path | Recipe,
    sets: Mapping[str, Any] | None = None,
    effects: Sequence[Mapping[str, Any]] = (),
    *,
    plugins: Plugins,
) -> Recipe:
    """The recipe of what a user names.

    - `what`: a recipe as `tacos_framework.load_recipe` finds it, one built in Python, the results folder of a
      study, or a scene by itself: ``scene.indoor``.
    - `sets`: dotted keys and the values to put there, as of ``--set``. Of a scene by itself, its own settings
      need no path: ``people`` is ``nodes.world.people``.

    Raises UserError when there is none, or with the faults of its form.
    """
    if isinstance(what, Recipe):
        return _changed(what, sets, effects) if sets or effects else what
    if str(what).startswith("scene."):
        return _scene_recipe(str(what), sets or {}, effects, plugins)
    file = Path(what) / "recipe.yaml"
    recipe = load_recipe(file if file.is_file() else what, sets, effects)
    if not isinstance(recipe, Recipe):
        raise UserError(
            Fault(str(what), f"it is a recipe of {recipe.use}, which has no camera", "a recipe of a study")
        )
    return recipe


def _changed(recipe: Recipe, sets: Mapping[str, Any] | None, effects: Sequence[Mapping[str, Any]]) -> Recipe:
    document = recipe.text or read_yaml_draft(to_yaml(recipe.as_data()), name=recipe.name)
    changed, faults = recipe_from(document, sets or {}, effects)
    if faults:
        raise UserError(faults)
    return changed


def _scene_recipe(
    scene: str, sets: Mapping[str, Any], effects: Sequence[Mapping[str, Any]], plugins: Plugins
) -> Recipe:
    """A study in a scene: nothing of it is designed, but a recipe is what all else is made for."""
    cls = plugins.resolve(scene, "scene")
    outdoors = optional(cls, SceneBase, "carrier") == "car"
    lux = sets.get("scenario.illumination_lux")
    by_day = outdoors and not (isinstance(lux, int | float) and lux < DUSK_LUX)
    own = {key: f"nodes.world.{key}" for key in sets if key.partition(".")[0] in cls.Config.model_fields}
    sets = {own.get(key, key): value for key, value in sets.items()}
    fields = cls.Config.model_fields
    if missing := [name for name, info in fields.items() if info.is_required() and name not in own]:
        raise UserError(
            [
                Fault(scene, f"needs {name}", fields[name].description or "", f"Give --set {name}=VALUE.")
                for name in missing
            ]
        )
    recipe: dict[str, Any] = {
        "tacos": 1,
        "name": scene,
        "rig": {"use": "rig.monocular"},
        "design": {
            "focal_length_mm": {"between": [1, 20]},
            "pitch_deg": {"between": [-30, 30]},
            "sensor": {"from": "image_sensors"},
        },
        "scenario": dict(OUTDOORS if by_day else INDOORS),
        "nodes": {
            "world": {"use": scene},
            "capture": {"use": "renderer.moderngl", "in": {"episode": "world"}},
            "frames": {"use": "sensor.affine-noise", "in": {"capture": "capture"}},
            "features": {"use": "task.orb-features", "in": {"frames": "frames"}},
        },
        "fitness": [{"score": "features.inliers", "weight": 1}],
        "optimizer": {"use": "optimizer.random", "evaluations": 1},
        "compare": {"cameras": ["basler_dart"]},
    }
    found, faults = recipe_from(read_yaml_draft(to_yaml(recipe), name=scene), sets, effects)
    if faults:
        raise UserError(faults)
    return found
