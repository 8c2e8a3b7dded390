"""The cameras to rank, as values of a study's design variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from pydantic import ValidationError

from tacos_framework import CatalogChoice, Continuous, Fault, UserError, did_you_mean, load_cameras
from tacos_framework.plan import Plan
from tacos_validation.rank_agreement.settings import RankedCameras


@dataclass(frozen=True)
class RankedCamera:
    """A camera to rank."""

    name: str
    values: Mapping[str, Any]
    """Plain values of the study's design variables, and of what else a product fixes of the rig."""


def cameras_of(asked: RankedCameras, plan: Plan) -> tuple[RankedCamera, ...]:
    """The cameras, with a value for every variable that the study designs.

    Raises UserError with everything that is wrong with any of them.
    """
    faults: list[Fault] = []
    cameras: list[RankedCamera] = []

    def add(name: str, where: str, values: Callable[[], Mapping[str, Any]]) -> None:
        try:
            given = {**asked.at, **values()}
            _check(given, plan, where)
            cameras.append(RankedCamera(name, given))
        except UserError as error:
            faults.extend(error.faults)

    for name in asked.products:
        add(name, "cameras.products", partial(_product, name, asked, plan))
    for name in asked.parts:
        add(name, "cameras.parts", partial(_of_part, name, asked, plan))
    for name, values in asked.by_values.items():
        add(name, f"cameras.by_values.{name}", partial(dict, values))
    if faults:
        raise UserError(list(dict.fromkeys(faults)))
    return tuple(cameras)


def _product(name: str, asked: RankedCameras, plan: Plan) -> Mapping[str, Any]:
    (camera,) = load_cameras([name], asked.catalog)
    if camera.rig != plan.rig.use:
        raise UserError(
            Fault(
                "cameras.products",
                f"{name} fixes variables of {camera.rig}, and the study's rig is {plan.rig.use}",
                f"products with variables of {plan.rig.use}",
                "Name other products, or give cameras by their values.",
            )
        )
    return camera.fixes


def _of_part(name: str, asked: RankedCameras, plan: Plan) -> Mapping[str, Any]:
    choices = {
        row.name: (variable.name, row)
        for variable in plan.space.variables
        if isinstance(variable, CatalogChoice)
        for row in variable.rows
    }
    if name not in choices:
        raise UserError(
            Fault(
                "cameras.parts",
                f"the study cannot choose a part {name!r}",
                "a part of the catalog it designs from",
                did_you_mean(name, choices) or "Give the camera by its values.",
            )
        )
    variable, row = choices[name]
    values = {**asked.at, variable: row.as_dict()}
    for solved, target in asked.match.items():
        ((quantity, wanted),) = target.items()
        values[solved] = solved_for(solved, quantity, wanted, values, plan)
    return values


def solved_for(variable: str, quantity: str, wanted: float, values: Mapping[str, Any], plan: Plan) -> float:
    """The value of a variable, within its bounds, at which the rig derives what is wanted.

    Raises UserError when there is no such variable or quantity, or it is not met between the bounds.
    """
    from scipy.optimize import brentq

    where = f"cameras.match.{variable}"
    bounded = {each.name: each for each in plan.space.variables if isinstance(each, Continuous)}
    if variable not in bounded:
        expected = "a variable that the study designs between bounds"
        remedy = did_you_mean(variable, bounded)
        raise UserError(Fault(where, f"there is no variable {variable!r} to solve for", expected, remedy))
    known = plan.rig.cls.derived_quantities
    if quantity not in known:
        remedy = did_you_mean(quantity, known)
        raise UserError(Fault(where, f"{plan.rig.use} derives no {quantity!r}", "", remedy))

    def missed_by(value: float) -> float:
        variables = plan.rig_variables({**values, variable: value})
        return float(plan.rig.instance.derived(variables)[quantity]) - wanted

    lower, upper = bounded[variable].lower, bounded[variable].upper
    try:
        return float(brentq(missed_by, lower, upper))
    except ValidationError as error:
        raise UserError(Fault(where, f"the rig refuses the camera: {error.errors()[0]['msg']}")) from error
    except ValueError as error:  # brentq: no change of sign
        what = f"{quantity} is not {wanted:g} for any {variable} from {lower:g} to {upper:g}"
        raise UserError(Fault(where, what, "a value that its bounds allow")) from error


def _check(values: Mapping[str, Any], plan: Plan, where: str) -> None:
    if left := [name for name in plan.space.names if name not in values]:
        raise UserError(
            Fault(
                where,
                f"a camera leaves {', '.join(left)} free",
                "a value for every variable that the study designs",
                "Give what cameras share under cameras.at.",
            )
        )
    names = (*plan.space.names, *plan.rig.cls.Variables.model_fields)
    for name in values:
        if name not in names:
            raise UserError(
                Fault(where, f"the study has no variable {name!r}", "", did_you_mean(name, names))
            )
    try:
        plan.rig_variables(values)
    except ValidationError as error:
        raise UserError(Fault(where, f"the rig refuses it: {error.errors()[0]['msg']}")) from error
