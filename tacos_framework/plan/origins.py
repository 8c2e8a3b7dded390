"""Origins of the figures that sensors and effects simulate parts with: known of the part, or assumed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tacos_framework.catalog import in_words
from tacos_framework.contracts import SensorBase, optional
from tacos_framework.plan.component import ConfiguredComponent
from tacos_framework.plan.feasibility import derived_of
from tacos_framework.plan.notes import catalog_choices, middle
from tacos_framework.plan.plan import Plan
from tacos_framework.values import Camera
from tacos_framework.variables.design_space import CatalogChoice


def says_origins(component: ConfiguredComponent) -> bool:
    return callable(optional(component.cls, SensorBase, "origins"))


def is_assumed(origin: str) -> bool:
    """True of the origin of a figure that nobody states of the part; see `SensorBase.origins`."""
    return origin.startswith("assumed")


def cameras_of_parts(plan: Plan, choice: CatalogChoice) -> list[Camera]:
    """For each part that is the image sensor of a camera, or has one, the camera it makes."""
    others, found = middle(plan), []
    for row in choice.rows:
        part = row.as_dict()
        values = {**others, choice.name: part}
        if derived_of(plan, values) is not None:
            sensor = part.get("sensor") or row.name
            found += [each for each in _cameras(plan, values) if each.electrons.sensor == sensor][:1]
    return found


def assumed_figures(component: ConfiguredComponent, cameras: Sequence[Camera]) -> list[list[str]]:
    """The figures that a component assumes of each camera."""
    return [
        [figure for figure, origin in _origins(component, camera).items() if is_assumed(origin)]
        for camera in cameras
    ]


def notes_on_assumptions(plan: Plan) -> Iterator[str]:
    """Of each sensor model and effect, how many parts it assumes a figure of, and which figures."""
    components = list(filter(says_origins, [*plan.nodes.values(), *plan.effects]))
    for choice in catalog_choices(plan):
        cameras = cameras_of_parts(plan, choice)
        for component in components:
            assumed = assumed_figures(component, cameras)
            parts_of = Counter(figure for figures in assumed for figure in figures)
            if parts_of:
                named = ", ".join(f"{in_words(figure)} ({n})" for figure, n in parts_of.most_common())
                yield (
                    f"{component.use} assumes figures of {sum(map(bool, assumed))} of {len(cameras)} parts "
                    f"of {choice.catalog.name}: {named}."
                )


def notes_on_noise(plan: Plan, cameras: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Sentences on where noise, and what effects assume of cameras, come from, as their components say."""
    sensors_by_origin: dict[tuple[str, str], list[str]] = {}
    for name, part in {**plan.nodes, **{f"effects.{each.name}": each for each in plan.effects}}.items():
        if not says_origins(part):
            continue
        for values in cameras:
            if any(variable.startswith(f"{name}.") for variable in values):
                continue  # its settings are designed: the plan holds no model of this camera
            try:
                for sensor, phrase in _phrases(plan, part, values):
                    simulated = "Noise" if name in plan.nodes else part.use
                    sensors_by_origin.setdefault((simulated, phrase), []).append(sensor)
            except Exception as error:  # noqa: BLE001 - a remark must not cost a study its results
                yield f"{part.origin} has remarks on cameras, but fails to say them: {error}"
    for (simulated, phrase), sensors in sensors_by_origin.items():
        yield f"{simulated} simulated for {', '.join(dict.fromkeys(sensors))}: {phrase}."


def _phrases(
    plan: Plan, component: ConfiguredComponent, values: Mapping[str, Any]
) -> Iterator[tuple[str, str]]:
    """Name of each image sensor of a camera, and the origins of its figures as one phrase."""
    for camera in _cameras(plan, values):
        phrases = [
            f"{in_words(name)} {_phrase(origin)}" for name, origin in _origins(component, camera).items()
        ]
        if phrases:
            yield camera.electrons.sensor or "a sensor without a name", "; ".join(phrases)


def _cameras(plan: Plan, values: Mapping[str, Any]) -> Sequence[Camera]:
    variables = plan.rig_variables(values)
    with plan.rig.calling("build"):
        return tuple(plan.rig.instance.build(variables).cameras)


def _origins(component: ConfiguredComponent, camera: Camera) -> Mapping[str, str]:
    with component.calling("origins"):
        return dict(component.instance.origins(camera))


def _phrase(origin: str) -> str:
    return {"catalog": "as the catalog states", "settings": "as the recipe sets"}.get(origin, origin)
