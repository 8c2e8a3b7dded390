"""Cameras named by effects and design variables have to be those of the rig."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tacos_framework.errors import did_you_mean
from tacos_framework.plan.component import ConfiguredComponent, EffectPart
from tacos_framework.plan.findings import RecipeFindings
from tacos_framework.plan.targets import target_of
from tacos_framework.settings import KeyPath, check
from tacos_framework.variables.design_space import DesignSpace


def check_camera_names(
    findings: RecipeFindings,
    rig: ConfiguredComponent,
    fixed: Mapping[str, Any],
    space: DesignSpace,
    nodes: Mapping[str, ConfiguredComponent],
    effects: Mapping[str, EffectPart],
) -> None:
    """Names of cameras in ``cameras:`` of effects, and in design variables, are those of the rig."""
    named = [*_named_by_effects(findings, nodes, effects), *_named_by_design(findings, nodes, effects)]
    if not named:
        return
    known = _cameras_of(findings, rig, fixed, space)
    for path, camera, acts_on in named:
        if camera not in known:
            what = f"{rig.use} has no camera {camera!r}"
            findings.add(path, what, "a camera of the rig", did_you_mean(camera, known))
        elif acts_on is not None and camera not in acts_on:
            what = f"the effect does not act on camera {camera!r}, but on {', '.join(acts_on)}"
            findings.add(path, what, "a camera that has the effect")


Named = tuple[KeyPath, str, tuple[str, ...] | None]
"""A place, the camera it names, and the cameras that an effect there acts on where that matters."""


def _named_by_effects(
    findings: RecipeFindings, nodes: Mapping[str, ConfiguredComponent], effects: Mapping[str, EffectPart]
) -> Iterator[Named]:
    for i, name in enumerate(findings.recipe.effect_names):
        for j, camera in enumerate(effects[name].cameras or ()):
            yield ("effects", i, "cameras", j), camera, None
    for name, part in nodes.items():
        for j, camera in enumerate(getattr(part, "cameras", None) or ()):
            yield ("nodes", name, "cameras", j), camera, None


def _named_by_design(
    findings: RecipeFindings, nodes: Mapping[str, ConfiguredComponent], effects: Mapping[str, EffectPart]
) -> Iterator[Named]:
    for variable in findings.recipe.design:
        target = target_of(variable, findings.recipe.effect_names)
        if target.camera is not None:
            part = {"node": nodes, "effect": effects}[target.kind][target.owner]
            yield ("design", variable), target.camera, getattr(part, "cameras", None)


def _cameras_of(
    findings: RecipeFindings, rig: ConfiguredComponent, fixed: Mapping[str, Any], space: DesignSpace
) -> list[str]:
    """Names of the cameras that the rig has at either end of the design space."""
    names: dict[str, None] = {}
    for end in ("lower", "upper"):
        values = space.decode([getattr(gene, end) for gene in space.genes]).as_dict()
        own = {name: value for name, value in values.items() if "." not in name}
        variables, _, _ = check(rig.cls.Variables, {**fixed, **own}, findings.recipe.where)
        if variables is not None:
            with rig.calling("build"):
                names.update((camera.name, None) for camera in rig.instance.build(variables).cameras)
    return list(names)
