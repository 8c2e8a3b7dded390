"""The camera a user means: a product, what a study designed, or figures of her own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tacos_framework import (
    CatalogChoice,
    Fault,
    OffTheShelf,
    Rig,
    UserError,
    also_called,
    camera_names,
    did_you_mean,
    load_cameras,
)
from tacos_framework.plan import Plan
from tacos_framework.store import DESIGNED, read_result

_NAMED = 3
"""Products that a message names of those that fit."""

CameraName = str | Mapping[str, Any] | None
"""A product or a camera of a run by name, values of design variables by theirs, or None for the default."""


@dataclass(frozen=True)
class CameraChoice:
    title: str
    values: Mapping[str, Any]
    """Plain values of the study's design variables, those included that a product fixes."""
    assumed: tuple[str, ...] = ()
    """Design variables nobody gave a value; each is in the middle of what it may be."""


def choose_camera(plan: Plan, camera: CameraName = None, run: Path | None = None) -> CameraChoice:
    """The camera a user means.

    - `plan`: the study whose rig builds it.
    - `camera`: the name of a product in the recipe's catalog of cameras, or of a camera of the run; or values
      by the names of design variables and of variables of the rig, where a part of a catalog may be given by
      its name. None stands for the camera the run has designed; without a run for the first product the
      recipe compares with, or, where it names none, for the middle of the design space.
    - `run`: the results folder the study came from.

    Raises UserError when there is no such camera, it is one of another kind of rig, or the rig refuses its
    values.
    """
    if run is not None and not isinstance(camera, Mapping):
        return _checked(plan, _of_run(run, camera or DESIGNED))
    if camera is None and plan.cameras:
        camera = plan.cameras[0].name
    if isinstance(camera, str):
        product = _product(plan, camera)
        return _checked(plan, _completed(plan, product.title, product.fixes))
    title = "the camera given" if camera else "the middle of the design space"
    return _checked(plan, _completed(plan, title, camera or {}))


def built_rig(plan: Plan, camera: CameraChoice) -> Rig:
    with plan.rig.calling("build"):
        rig: Rig = plan.rig.instance.build(plan.rig_variables(camera.values))
    return rig


def _of_run(run: Path, name: str) -> CameraChoice:
    cameras = read_result(run).get("cameras")
    if not isinstance(cameras, dict):
        raise UserError(Fault(str(run), "it is not the result of a study", "a study that has ended"))
    if name not in cameras:
        raise UserError(Fault(name, f"the run {run} has no such camera", "", did_you_mean(name, cameras)))
    if not isinstance(cameras[name], dict) or not isinstance(cameras[name].get("camera"), dict):
        raise UserError(Fault(str(run), f"the camera {name} has no values", "a study that has ended"))
    return CameraChoice(str(cameras[name].get("title", name)), cameras[name]["camera"])


def _product(plan: Plan, name: str) -> OffTheShelf:
    compare = plan.recipe.compare
    catalog = compare.catalog if compare else "cameras"
    folder = plan.recipe.folder_of(("compare", "catalog"))
    (product,) = load_cameras([name], catalog, folder)
    if product.rig != plan.rig.use:
        every = load_cameras(camera_names(catalog, folder), catalog, folder)
        fitting = [each.name for each in every if each.rig == plan.rig.use]
        raise UserError(
            Fault(
                name,
                f"{product.title} is a camera of {product.rig}, and the recipe has {plan.rig.use}",
                f"a camera of {plan.rig.use}",
                f"Name one of {', '.join(fitting[:_NAMED])}." if fitting else "Choose a recipe with its rig.",
            )
        )
    return product


def _completed(plan: Plan, title: str, given: Mapping[str, Any]) -> CameraChoice:
    _refuse_unknown(plan, given)
    known = {name: _part(plan, name, value) for name, value in given.items()}
    product = OffTheShelf(
        name="given", title=title, maker="?", rig=plan.rig.use, fixes=known or {"": 0}, sources=("given",)
    )
    free = plan.free_of(product)
    middle = free.decode([(gene.lower + gene.upper) / 2 for gene in free.genes]).as_dict()
    return CameraChoice(title, {**known, **middle}, tuple(free.names))


def _refuse_unknown(plan: Plan, given: Mapping[str, Any]) -> None:
    variables = plan.rig.cls.Variables
    known, called = {*plan.space.names, *variables.model_fields}, also_called(variables)
    faults = [
        Fault(name, f"{plan.rig.use} has no variable {name!r}", "", did_you_mean(name, known, called))
        for name in given
        if name not in known
    ]
    if faults:
        raise UserError(faults)


def _part(plan: Plan, name: str, value: Any) -> Any:
    variable = next((each for each in plan.space.variables if each.name == name), None)
    if not (isinstance(variable, CatalogChoice) and isinstance(value, str)):
        return value
    rows = {row.name: row for row in variable.catalog.rows}
    if value not in rows:
        what = f"the catalog {variable.catalog.name} has no part {value!r}"
        raise UserError(Fault(name, what, "", did_you_mean(value, rows)))
    return rows[value].as_dict()


def _checked(plan: Plan, camera: CameraChoice) -> CameraChoice:
    try:
        plan.rig_variables(camera.values)
    except ValidationError as error:
        raise UserError(
            Fault(
                ".".join(map(str, (camera.title, *each["loc"]))), f"{plan.rig.use} refuses it: {each['msg']}"
            )
            for each in error.errors()
        ) from error
    return camera
