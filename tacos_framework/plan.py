"""From a recipe and the installed plugins to a plan: all components found, all settings and wires checked."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from tacos_framework.catalog import OffTheShelf, find_catalog, load_cameras
from tacos_framework.contracts import formation_order, learns
from tacos_framework.design_space import (
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
    Variable,
)
from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.fitness import Constraint, Fitness, Term
from tacos_framework.graph import Graph, Node, signature_of, wiring_faults
from tacos_framework.plugins import Plugins
from tacos_framework.recipe import Between, Choose, FromCatalog, NodeUse, Recipe, Scenario, Use, Weighted
from tacos_framework.settings import Path, Settings, check, with_paths_from


@dataclass(frozen=True)
class Part:
    """A component class with its checked settings."""

    use: str
    cls: type[Any]
    config: Settings

    def make(self, overrides: Mapping[str, Any] | None = None, **supplied: Any) -> Any:
        """Build the component, with some settings replaced."""
        if not overrides:
            return self.cls(self.config, **supplied)
        merged = {**self.config.model_dump(mode="json", by_alias=True), **overrides}
        return self.cls(self.cls.Config.model_validate_json(json.dumps(merged)), **supplied)


@dataclass(frozen=True)
class Plan:
    """A recipe with everything found and checked.

    Parameters
    ----------
    recipe
        The recipe.
    graph
        The wired graph.
    nodes
        The component of each node.
    rig
        The component that builds the rig.
    fixed
        Variables of the rig that the recipe fixes.
    space
        The variables it designs.
    effects
        Effects in the order of image formation.
    """

    recipe: Recipe
    graph: Graph
    nodes: Mapping[str, Part]
    rig: Part
    fixed: Mapping[str, Any]
    space: DesignSpace
    fitness: Fitness
    constraints: tuple[Constraint, ...]
    effects: tuple[Part, ...]
    optimizer: Part
    executor: Part
    cameras: tuple[OffTheShelf, ...] = ()

    @property
    def trainable(self) -> tuple[str, ...]:
        """Task nodes that learn."""
        return tuple(n for n in self.graph.of_kind("task") if learns(self.nodes[n].cls))

    def rig_variables(self, values: Mapping[str, Any]) -> Settings:
        """The rig's variables for plain values of the design variables.

        Raises
        ------
        pydantic.ValidationError
            When the rig refuses a value.
        """
        own = {name: value for name, value in values.items() if "." not in name}
        return self.rig.cls.Variables.model_validate_json(json.dumps({**self.fixed, **own}))


def make_plan(recipe: Recipe, plugins: Plugins, faults: Sequence[Fault] = ()) -> Plan:
    """Check a recipe against the installed plugins.

    Parameters
    ----------
    recipe
        The recipe; may be a draft when `faults` says so.
    plugins
        The installed plugins.
    faults
        Faults found while reading it.

    Raises
    ------
    UserError
        With those faults and all that are found here.
    """
    checker = _Checker(recipe, plugins, list(faults))
    plan = checker.plan()
    if checker.faults or plan is None:
        raise UserError(sorted(checker.faults, key=_place))
    return plan


def _place(fault: Fault) -> tuple[str, int, int]:
    """Sort key: faults of a file by line and column."""
    found = re.match(r"(.*?):(\d+):(\d+)", fault.where)
    return (found[1], int(found[2]), int(found[3])) if found else (fault.where, 0, 0)


_FITTING_CAMERA = {
    "sensor": (
        "a camera of which it knows enough",
        "Give the missing figures as settings of the node, or choose from a catalog that knows.",
    ),
    "task": ("cameras it can judge", "Choose another rig, or other values of its variables."),
}
"""Kind of a node that takes no camera -> what it expects, what to do."""


@dataclass
class _Checker:
    """Goes through a recipe section by section and keeps every fault."""

    recipe: Recipe
    plugins: Plugins
    faults: list[Fault] = field(default_factory=list)

    def plan(self) -> Plan | None:
        recipe = self.recipe
        nodes, graph = self._graph()
        rig, fixed = self._rig()
        space = self._space(rig, fixed, nodes)
        self._constraints(rig)
        self._scores(nodes)
        effects = self._effects()
        optimizer = self._part(recipe.optimizer, "optimizer", ("optimizer",)) if recipe.optimizer else None
        executor = self._part(recipe.executor, "executor", ("executor",))
        cameras = self._cameras(rig)
        if self.faults or not (graph and rig and space and optimizer and executor):
            return None
        return Plan(
            recipe=recipe,
            graph=graph,
            nodes=nodes,
            rig=rig,
            fixed=fixed,
            space=space,
            fitness=Fitness(tuple(Term(term.score, term.weight) for term in recipe.fitness)),
            constraints=tuple(Constraint(name, b.min, b.max) for name, b in recipe.constraints.items()),
            effects=effects,
            optimizer=optimizer,
            executor=executor,
            cameras=cameras,
        )

    def _add(self, path: Path, what: str, expected: str = "", remedy: str = "") -> None:
        self.faults.append(Fault(self.recipe.where(path), what, expected, remedy))

    def _class(self, use: str, kind: str, path: Path) -> type[Any] | None:
        try:
            return self.plugins.resolve(use, kind, where=self.recipe.where((*path, "use")))
        except UserError as error:
            self.faults.extend(error.faults)
            return None

    def _part(self, use: Use, kind: str, path: Path) -> Part | None:
        cls = self._class(use.use, kind, path)
        return None if cls is None else self._configured(cls, use.use, use.settings, path)

    def _configured(self, cls: type[Any], use: str, settings: Mapping[str, Any], path: Path) -> Part | None:
        if self.recipe.folder is not None:
            settings = with_paths_from(self.recipe.folder, cls.Config, settings)
        config, faults, _ = check(
            cls.Config, dict(settings), lambda below: self.recipe.where((*path, *below))
        )
        self.faults.extend(faults)
        if config is None:
            return None
        part = Part(use, cls, config)
        if use.partition(".")[0] in ("optimizer", "executor"):  # these are built by the study, for good
            return part
        try:
            part.make()  # what a component refuses, such as a file that is not there, shows now
        except UserError as error:
            self._adopt(path, error)
            return None
        return part

    def _adopt(self, path: Path, error: UserError) -> None:
        """Keep the faults of a part of the recipe that was read elsewhere, with its place in the recipe."""
        place = self.recipe.where(path)
        for fault in error.faults:
            self.faults.append(Fault(f"{place}: {fault.where}", fault.what, fault.expected, fault.remedy))

    # nodes ------------------------------------------------------------------------------------------------

    def _graph(self) -> tuple[dict[str, Part], Graph | None]:
        parts: dict[str, Part] = {}
        nodes: dict[str, Node] = {}
        for name, use in self.recipe.nodes.items():
            kind = use.use.partition(".")[0]
            if kind not in ("scene", "renderer", "sensor", "task"):
                self._add(
                    ("nodes", name, "use"),
                    f"{use.use} cannot be a node",
                    "a scene, renderer, sensor or task",
                    {"effect": "List it under effects:.", "rig": "Put it under rig:."}.get(kind, ""),
                )
                continue
            cls = self._class(use.use, kind, ("nodes", name))
            if cls is None:
                continue
            nodes[name] = Node(name, kind, use.use, signature_of(cls, kind), use.inputs)
            self._training(name, use, cls)
            if part := self._configured(cls, use.use, use.settings, ("nodes", name)):
                parts[name] = part
        if len(nodes) < len(self.recipe.nodes):
            return parts, None
        wiring = wiring_faults(nodes, lambda path: self.recipe.where(("nodes", *path)))
        self.faults.extend(wiring)
        return parts, None if wiring or not nodes else Graph(nodes)

    def _training(self, name: str, use: NodeUse, cls: type[Any]) -> None:
        if use.train is not None and not learns(cls):
            self._add(("nodes", name, "train"), f"{use.use} does not learn", "", "Remove train:.")
        elif use.train is not None and (kind := getattr(cls, "Training", None)) is not None:
            place = ("nodes", name, "train")
            self.faults.extend(
                check(kind, use.train.settings, lambda below: self.recipe.where((*place, *below)))[1]
            )

    # rig and design ---------------------------------------------------------------------------------------

    def _rig(self) -> tuple[Part | None, dict[str, Any]]:
        use = self.recipe.rig
        cls = self._class(use.use, "rig", ("rig",)) if use else None
        if use is None or cls is None:
            return None, {}
        variables = cls.Variables.model_fields
        fixed = {name: value for name, value in use.settings.items() if name in variables}
        known = {name: value for name, value in use.settings.items() if name in cls.Config.model_fields}
        for name in use.settings:
            if name not in variables and name not in cls.Config.model_fields:
                remedy = did_you_mean(name, [*variables, *cls.Config.model_fields])
                self._add(
                    ("rig", name), f"unknown key {name!r}", f"a setting or variable of {use.use}", remedy
                )
        for name in fixed:
            if name in self.recipe.design:
                self._add(
                    ("rig", name), f"{name!r} is fixed here and designed under design:", "one of the two"
                )
        return self._configured(cls, use.use, known, ("rig",)), fixed

    def _space(
        self, rig: Part | None, fixed: Mapping[str, Any], nodes: Mapping[str, Part]
    ) -> DesignSpace | None:
        variables = []
        for name, entry in self.recipe.design.items():
            unit = self._unit(name, rig, nodes)
            if unit is not None and (variable := self._variable(name, entry, unit)):
                variables.append(variable)
        if rig is None:
            return None
        given = {*fixed, *self.recipe.design}
        for name, info in rig.cls.Variables.model_fields.items():
            if info.is_required() and name not in given:
                self._add(
                    ("rig",),
                    f"{rig.use} needs {name!r}",
                    info.description or "",
                    "Give it under rig: (fixed) or design: (designed).",
                )
        if len(variables) < len(self.recipe.design) or not variables:
            return None
        space = DesignSpace(tuple(variables))
        self._refused_by_rig(rig, fixed, space, given)
        if not self.faults:
            self._unfit_cameras(rig, fixed, space, nodes)
        return space

    def _unit(self, name: str, rig: Part | None, nodes: Mapping[str, Part]) -> str | None:
        """Unit of a design variable; None, and a fault, when there is no such variable."""
        node, _, setting = name.partition(".")
        if not setting:
            fields = rig.cls.Variables.model_fields if rig else {}
            owner = rig.use if rig else "the rig"
            if rig is None:
                return "1"
        elif node == "scenario":
            fields, owner = Scenario.model_fields, "scenario"
        elif node in nodes:
            fields, owner = nodes[node].cls.Config.model_fields, nodes[node].use
        elif node in self.recipe.nodes:
            return "1"  # its component is at fault already
        else:
            self._add(
                ("design", name), f"there is no node {node!r}", "", did_you_mean(node, self.recipe.nodes)
            )
            return None
        if (wanted := setting or node) not in fields:
            self._add(
                ("design", name), f"{owner} has no variable {wanted!r}", "", did_you_mean(wanted, fields)
            )
            return None
        extra = fields[wanted].json_schema_extra
        return str(extra.get("unit", "1")) if isinstance(extra, dict) else "1"

    def _variable(self, name: str, entry: Any, unit: str) -> Variable | None:
        path = ("design", name)
        try:
            if isinstance(entry, Between):
                lower, upper = entry.between
                if entry.integer:
                    return Integer(name, int(lower), int(upper), unit)
                return Continuous(name, lower, upper, unit)
            if isinstance(entry, Choose):
                return Categorical(name, entry.choose)
            if isinstance(entry, FromCatalog):
                catalog = find_catalog(entry.catalog, folder=self.recipe.folder)
                return CatalogChoice(name, catalog, entry.scheme, entry.columns, entry.distance)
        except UserError as error:
            self._adopt(path, error)
        except ValueError as error:
            self._add(path, str(error))
        return None

    def _refused_by_rig(
        self, rig: Part, fixed: Mapping[str, Any], space: DesignSpace, given: set[str]
    ) -> None:
        """Try the two corners of the space on the rig, so that bad bounds and fixed values show now."""
        variables = rig.cls.Variables
        if any(info.is_required() and name not in given for name, info in variables.model_fields.items()):
            return
        lower = [gene.lower for gene in space.genes]
        upper = [gene.upper for gene in space.genes]
        seen: set[str] = set()
        for genes in (lower, upper):
            values = {n: v for n, v in space.decode(genes).as_dict().items() if "." not in n}
            where = partial(self._where_variable, fixed)
            for fault in check(variables, {**fixed, **values}, where)[1]:
                if fault.where not in seen:
                    seen.add(fault.where)
                    self.faults.append(fault)

    def _unfit_cameras(
        self, rig: Part, fixed: Mapping[str, Any], space: DesignSpace, nodes: Mapping[str, Part]
    ) -> None:
        """Ask sensors and tasks that do not take every camera whether they take any that can be chosen."""
        asking = {
            name: part
            for name, part in nodes.items()
            if callable(getattr(part.cls, "lacks", None))
            and not any(variable.name.startswith(f"{name}.") for variable in space.variables)
        }
        if not asking:
            return
        rigs = self._choosable_rigs(rig, fixed, space)
        for name, part in asking.items():
            reasons = [part.make().lacks(each) for each in rigs]
            wanted, remedy = _FITTING_CAMERA.get(part.use.partition(".")[0], _FITTING_CAMERA["task"])
            if reasons and all(reasons):
                self._add(
                    ("nodes", name),
                    min(map(str, reasons), key=len),  # of the camera that lacks least
                    f"{wanted}; of {len(reasons)} tried there is none",
                    remedy,
                )

    def _choosable_rigs(self, rig: Part, fixed: Mapping[str, Any], space: DesignSpace) -> list[Any]:
        """The rig for every row of each catalog the recipe chooses from; all else at its lower bound."""
        corner = space.decode([gene.lower for gene in space.genes]).as_dict()
        own = {name: value for name, value in corner.items() if "." not in name}
        choices = [v for v in space.variables if isinstance(v, CatalogChoice) and v.name in own]
        tried = [{**own, choice.name: row.as_dict()} for choice in choices for row in choice.rows] or [own]
        builder = rig.make()
        built = []
        for values in tried:
            variables, faults, _ = check(rig.cls.Variables, {**fixed, **values}, self.recipe.where)
            if not faults:
                built.append(builder.build(variables))
        return built

    def _where_variable(self, fixed: Mapping[str, Any], path: Path) -> str:
        section = "rig" if path and path[0] in fixed else "design"
        return self.recipe.where((section, *path))

    # what is judged ---------------------------------------------------------------------------------------

    def _constraints(self, rig: Part | None) -> None:
        for name, bounds in self.recipe.constraints.items():
            if rig is not None and name not in (known := rig.cls.derived_quantities):
                self._add(
                    ("constraints", name), f"{rig.use} derives no {name!r}", "", did_you_mean(name, known)
                )
            if bounds.min is None and bounds.max is None:
                self._add(("constraints", name), f"{name!r} has no bound", "min, max, or both")
            elif bounds.min is not None and bounds.max is not None and bounds.min > bounds.max:
                self._add(("constraints", name), f"min {bounds.min:g} is above max {bounds.max:g}")

    def _scores(self, nodes: Mapping[str, Part]) -> None:
        scores = {
            f"{name}.{score}" for name, part in nodes.items() for score in getattr(part.cls, "scores", ())
        }
        seen: set[str] = set()
        for i, term in enumerate(self.recipe.fitness):
            if term.score in seen:
                self._add(("fitness", i, "score"), f"{term.score} stands twice", "each score once")
            seen.add(term.score)
            if term.score not in scores and self._could_exist(term, nodes):
                self._add(
                    ("fitness", i, "score"),
                    f"no task reports {term.score!r}",
                    "node.score",
                    did_you_mean(term.score, scores),
                )

    def _could_exist(self, term: Weighted, nodes: Mapping[str, Part]) -> bool:
        """False where the score's node is at fault already."""
        node = term.score.partition(".")[0]
        return node in nodes or node not in self.recipe.nodes

    def _effects(self) -> tuple[Part, ...]:
        parts = [self._part(use, "effect", ("effects", i)) for i, use in enumerate(self.recipe.effects)]
        found = [part for part in parts if part is not None]
        return tuple(sorted(found, key=lambda part: formation_order(part.cls)))

    def _cameras(self, rig: Part | None) -> tuple[OffTheShelf, ...]:
        compare = self.recipe.compare
        if compare is None or rig is None:
            return ()
        try:
            cameras = load_cameras(compare.cameras, compare.catalog, folder=self.recipe.folder)
        except UserError as error:
            self._adopt(("compare", "cameras"), error)
            return ()
        for camera in cameras:
            for name in camera.fixes:
                if name not in rig.cls.Variables.model_fields:
                    self._add(
                        ("compare", "cameras"),
                        f"camera {camera.name!r} fixes {name!r}, which {rig.use} does not have",
                        "",
                        "Compare cameras made for this rig.",
                    )
        return tuple(cameras)
