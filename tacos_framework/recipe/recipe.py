"""Recipes: one YAML file, or the same thing built in Python.

Reading checks the form of a recipe and keeps the line and column of every key. Whether its components exist
and fit together is the business of `tacos_framework.plan`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    model_validator,
)

from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.recipe.effect_names import effect_names
from tacos_framework.recipe.notes import quoting
from tacos_framework.recipe.overrides import with_overrides
from tacos_framework.settings import Settings, check, setting
from tacos_framework.settings.yaml_reader import Document, read_yaml_draft

FORMAT = 1
"""The recipe format this version reads (``tacos: 1``)."""

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]


class Use(BaseModel):
    """A component and its settings: ``{use: kind.name, setting: value, ...}``."""

    model_config = ConfigDict(frozen=True, extra="allow")

    use: str = Field(description="The component, kind.name.", pattern=r"^[a-z]+\.[a-z0-9-]+$")

    @property
    def settings(self) -> dict[str, Any]:
        """The settings given, without ``use`` and wiring."""
        return dict(self.model_extra or {})


class Train(BaseModel):
    """How a trainable task learns during the study; further keys go to the task as its budget's settings."""

    model_config = ConfigDict(frozen=True, extra="allow")

    weights: Literal["shared", "branched", "frozen"] = "shared"
    epochs: int = Field(1, ge=1, description="Passes over the training frames for each candidate.")
    frames: int | None = Field(
        None, ge=1, description="Frames to train on; as many as the scene gives if absent."
    )

    @property
    def settings(self) -> dict[str, Any]:
        """The keys only the task knows."""
        return dict(self.model_extra or {})


class EffectUse(Use):
    """An effect of the camera, and which of the rig's cameras have it."""

    name: str | None = Field(
        None,
        description="What design variables call it; its component's name if absent.",
        pattern=r"^[a-z][a-z0-9_-]*$",
    )
    cameras: tuple[str, ...] | None = Field(
        None, description="The cameras it acts on; all of the rig if absent.", min_length=1
    )


class NodeUse(Use):
    """A node of the graph: a component, wired by ``in: {port: node}``."""

    inputs: dict[str, str] = Field(
        default_factory=dict, alias="in", description="Which node feeds each port."
    )
    train: Train | None = Field(None, description="Training during the study, for trainable tasks.")


class Between(Settings):
    """A number to design: ``{between: [lower, upper]}``."""

    between: tuple[float, float] = setting(help="Lower and upper bound.")
    integer: bool = setting(False, help="Whole numbers only.")


class Choose(Settings):
    """One of some values: ``{choose: [a, b]}``."""

    choose: tuple[str | bool | int | float, ...] = setting(help="The values to choose from.", min_length=1)


class FromCatalog(Settings):
    """A part from a catalog: ``{from: image_sensors}``."""

    model_config = ConfigDict(populate_by_name=True)

    catalog: str = setting(help="Name of a shipped catalog, or a path beside the recipe.", alias="from")
    scheme: Literal["quantized", "discrete"] = setting(
        "quantized", help="How the optimizer sees the rows (paper, Sec. 3.3)."
    )
    columns: tuple[str, ...] | None = setting(
        None, help="Columns that span the quantized space; those of the catalog's own choice if absent."
    )
    distance: Literal["normalised", "plain"] = setting(
        "normalised",
        help="Distance to the nearest row: each column over its range, or the paper's plain one.",
    )


def _kind_of_variable(raw: Any) -> str:
    if not isinstance(raw, dict | Between | Choose | FromCatalog):
        return "<between>"  # which says what an entry looks like
    keys = raw if isinstance(raw, dict) else raw.model_dump(by_alias=True)
    return next((f"<{key}>" for key in ("from", "choose") if key in keys), "<between>")


Variable = Annotated[
    Annotated[Between, Tag("<between>")]
    | Annotated[FromCatalog, Tag("<from>")]
    | Annotated[Choose, Tag("<choose>")],
    Discriminator(_kind_of_variable),
]
"""One entry of ``design:``, told apart by its first word."""


class Bounds(Settings):
    """What a derived quantity, or a column of a part, must be."""

    model_config = ConfigDict(populate_by_name=True)

    min: float | None = setting(None, help="Smallest allowed value.")
    max: float | None = setting(None, help="Largest allowed value.")
    word: str | None = setting(None, help="The only allowed word, as in global.", alias="is")
    any_of: tuple[str, ...] = setting((), help="Allowed words, where there are several.")
    unknown: Literal["allow", "refuse"] = setting(
        "allow", help="What becomes of a part whose value nobody states."
    )

    @property
    def words(self) -> tuple[str, ...]:
        """All allowed words; none where it bounds numbers."""
        return self.any_of if self.word is None else (self.word, *self.any_of)


class Aim(Settings):
    """One of several aims that a front trades off."""

    quantity: str = setting(
        help="A derived quantity, a column such as sensor.power_w, a score, or fitness.", min_length=1
    )
    aim: Literal["max", "min"] = setting(help="Whether much or little of it is wanted.")


class Scenario(Settings):
    """Light and exposure, the same for every candidate."""

    illumination_lux: float = setting(20.0, help="Mean illuminance 1 m above the floor.", unit="lux", gt=0)
    gain_db: float = setting(5.0, help="Gain of the calibrated pixel; larger pixels need less.", unit="dB")
    exposure_ms: float = setting(30.0, help="Exposure time.", unit="ms", gt=0)
    f_number: float = setting(2.0, help="Focal length over aperture.", gt=0)


class NamedScenario(Scenario):
    """One of several scenarios."""

    name: str = setting(help="What results and design variables call it.", pattern=r"^[a-z][a-z0-9_]*$")
    weight: float = setting(1.0, help="Its weight in the mean over the scenarios.", gt=0)


def _count_of_scenarios(raw: Any) -> str:
    return "<several>" if isinstance(raw, list | tuple) else "<one>"


def _none_if_fixed(raw: Any) -> Any:
    if isinstance(raw, str) and raw != FIXED:
        raise ValueError("fixed, or a component: {use: control.NAME}")
    return None if raw == FIXED else raw


FIXED = "fixed"
"""``exposure: fixed``: every frame is taken with the exposure of the scenario."""

ExposureControl = Annotated[Use | None, BeforeValidator(_none_if_fixed)]
"""``exposure:``, fixed or a component that controls it."""

Scenarios = Annotated[
    Annotated[Scenario, Tag("<one>")] | Annotated[tuple[NamedScenario, ...], Tag("<several>")],
    Discriminator(_count_of_scenarios),
]
"""``scenario:``, a mapping or a list of them."""

_WITH_METADATA: Mapping[str, Any] = {"scenario": Scenarios, "exposure": ExposureControl}
"""Sections whose annotation says more than its type, of which a field keeps the type alone."""


class Weighted(Settings):
    """One term of the fitness."""

    score: str = setting(help="node.score, e.g. features.inliers.")
    weight: float = setting(help="Its weight in the sum; negative for scores to keep small.")


class RaceSettings(Settings):
    """When a candidate that is behind is scored no further."""

    standard_errors: float = setting(
        2.0,
        help="Standard errors of its mean paired difference to the leader it must be behind by.",
        gt=0,
    )
    min_blocks: int = setting(3, help="Blocks every candidate is scored on before any is dropped.", ge=2)


class StudySettings(Settings):
    """How candidates are compared."""

    episodes: int = setting(1, help="Episodes each candidate is scored on.", ge=1)
    renew_episodes: Literal["never", "each_generation"] = setting(
        "each_generation", help="Whether each generation sees new worlds."
    )
    renew_training: Literal["never", "each_generation", "each_candidate"] | None = setting(
        None, help="Whether tasks that learn are shown new worlds; by default as renew_episodes."
    )
    train_best: int = setting(
        0,
        help="Trainings on the best camera before the test, each in a new world; not with frozen weights.",
        ge=0,
    )
    scenarios: Literal["mean", "worst"] = setting(
        "mean", help="Of several scenarios, whether the weighted mean of their fitness counts, or the worst."
    )
    common_random_numbers: bool = setting(
        True, help="Candidates of a generation see the same episodes and noise."
    )
    blocks: int = setting(
        1, help="Parts of consecutive frames an episode is cut into; each is scored like an episode.", ge=1
    )
    on_error: Literal["fail_candidate", "stop"] = setting(
        "fail_candidate",
        help="What a defect of a component does that shows with one candidate: fail it, or stop the study.",
    )
    finalists: int = setting(
        3,
        help=(
            "Most promising candidates, scored once more on episodes of their own; the best of them wins. "
            "With 1 none is, unless scores do not compare."
        ),
        ge=1,
    )
    final_episodes: int | None = setting(
        None, help="Episodes the finalists are scored on; as many as `episodes` if absent.", ge=1
    )
    race: RaceSettings | None = setting(
        None, help="Drop candidates that are clearly behind, block by block; {} for the default rules."
    )

    @model_validator(mode="after")
    def _race_can_be_run(self) -> StudySettings:
        if self.race is None:
            return self
        if not self.common_random_numbers:
            raise ValueError("a race compares frame by frame, so common_random_numbers must be true")
        if self.episodes * self.blocks <= self.race.min_blocks:
            raise ValueError(
                f"a race over episodes x blocks = {self.episodes} x {self.blocks} ends before any candidate "
                f"can be dropped, after {self.race.min_blocks}: more of either are needed"
            )
        return self


class Compare(Settings):
    """Off-the-shelf cameras to set beside the design."""

    cameras: tuple[str, ...] = setting(help="Names in the catalog of cameras.", min_length=1)
    catalog: str = setting("cameras", help="Name of a shipped catalog of cameras, or a path.")
    evaluations: int = setting(
        30,
        help=(
            "Evaluations to search what each product leaves free, its finalists not counted; where tasks are "
            "trained, as many train them on a product that leaves nothing free."
        ),
        ge=1,
    )


class Test(Settings):
    """The scenes the design is tested on: other scenes than it was designed on."""

    __test__ = False  # not a pytest class

    seed: int = setting(help="Seed of the test scenes.", ge=0)
    frames: int | None = setting(None, help="Frames per episode; as in the design if absent.", ge=1)
    episodes: int = setting(1, help="Episodes every camera is tested on first.", ge=1)
    most_episodes: int | None = setting(
        None,
        help="Episodes are added until each comparison is decided, up to these; none are if absent.",
        ge=1,
    )
    margin: float = setting(
        0.01, help="Differences up to this share of the designed camera's fitness do not matter.", ge=0
    )
    confidence: float = setting(
        0.95, help="How sure a verdict must be, over all products and planned looks.", gt=0.5, lt=1
    )

    @model_validator(mode="after")
    def _most_are_no_fewer(self) -> Test:
        if self.most_episodes is not None and self.most_episodes < self.episodes:
            raise ValueError(f"most_episodes is {self.most_episodes}, fewer than episodes, {self.episodes}")
        return self


class Recipe(Settings):
    """What to design, how to simulate it, and what to score it by.

    Built from YAML by `load_recipe` or in Python with keyword arguments; both are equal in power.
    """

    model_config = ConfigDict(populate_by_name=True)

    tacos: Literal[1] = setting(FORMAT, help="Format of the recipe.")
    name: str = setting(help="What the study is called.", min_length=1, max_length=200)
    seed: int = setting(0, help="Everything random follows from it.", ge=0)
    rig: Use = setting(help="The component that builds cameras; variables given here are fixed.")
    design: dict[str, Variable] = setting(help="Variables of the rig, or node.setting.", min_length=1)
    constraints: dict[str, Bounds] = setting(
        {}, help="Bounds on quantities the rig derives, and on columns of parts (sensor.full_well_e)."
    )
    scenario: Scenarios = setting(
        Scenario(), help="Light and exposure; or a list of several, each with a name and a weight."
    )
    exposure: ExposureControl = setting(
        None, help="Who sets exposure time and gain from frame to frame; fixed as in the scenario if absent."
    )
    effects: tuple[EffectUse, ...] = setting((), help="Effects of the camera; each acts at its own stage.")
    nodes: dict[Name, NodeUse] = setting(help="The graph: components, wired by their ports.", min_length=1)
    fitness: tuple[Weighted, ...] = setting(help="Weighted sum of scores, maximised.", min_length=1)
    objectives: tuple[Aim, ...] = setting((), help="Aims that a front trades off, the fitness among them.")
    optimizer: Use = setting(help="The derivative-free optimizer.")
    executor: Use | None = setting(None, help="Where candidates are evaluated; in this process if absent.")
    study: StudySettings = setting(StudySettings(), help="How candidates are compared.")
    compare: Compare | None = setting(None, help="Off-the-shelf cameras to set beside the design.")
    test: Test | None = setting(None, help="Scenes the design is tested on.")
    notes: tuple[str, ...] = setting(
        (), help="What a reader of the results should know; {rig.binning} and the like quote the recipe."
    )

    _document: Document | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _seeds_differ(self) -> Recipe:
        if self.test is not None and self.test.seed == self.seed:
            raise ValueError(f"test.seed and seed are both {self.seed}: the test scenes would not be unseen")
        return self

    @model_validator(mode="after")
    def _notes_quote_what_is_there(self) -> Recipe:
        for note in self.notes:
            quoting(note, self.as_data())
        return self

    @model_validator(mode="after")
    def _racers_start_alike(self) -> Recipe:
        shared = [name for name, use in self.nodes.items() if use.train and use.train.weights == "shared"]
        if self.study.race is not None and shared:
            raise ValueError(
                f"study.race compares candidates that start alike, but {shared[0]} trains with shared "
                f"weights, so that each goes on where the one before stopped: set branched or frozen"
            )
        return self

    @property
    def quoted_notes(self) -> tuple[str, ...]:
        """The notes, with the settings they quote."""
        return tuple(quoting(note, self.as_data()) for note in self.notes)

    @property
    def scenarios(self) -> tuple[Scenario, ...]:
        """The scenarios each candidate is scored in; more than one of them have names and weights."""
        return (self.scenario,) if isinstance(self.scenario, Scenario) else self.scenario

    @property
    def effect_names(self) -> tuple[str, ...]:
        """What design variables call each effect, ``effects.NAME.setting``."""
        return effect_names([(effect.use, effect.name) for effect in self.effects])

    def keys_of(self, section: str) -> tuple[str, ...]:
        """The keys of a section, those among them whose values are at fault and so no part of the recipe."""
        written = self._document.data.get(section) if self._document is not None else None
        return tuple(written if isinstance(written, dict) else getattr(self, section))

    def without_echoes(self, faults: Sequence[Fault]) -> list[Fault]:
        """Without the faults of values that the text's reader has refused already."""
        return list(faults) if self._document is None else self._document.without_echoes(faults)

    def where(self, path: Sequence[str | int]) -> str:
        """File, line and column of a key; its dotted name for a recipe built in Python."""
        if self._document is not None:
            return self._document.where(tuple(path))
        return ".".join(map(str, ("recipe", *path)))

    def folder_of(self, path: Sequence[str | int]) -> Path | None:
        """The folder that a relative path at a key starts from; None for the working folder."""
        return self._document.folder_of(path) if self._document is not None else None

    def as_data(self) -> dict[str, Any]:
        """The recipe as plain data, every default filled in; `parse_recipe` of it gives an equal recipe."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)


def parse_recipe(text: str, *, name: str = "recipe") -> tuple[Recipe, list[Fault]]:
    """A recipe from text, and the faults of its form; see `read_any_recipe`."""
    return recipe_from(read_yaml_draft(text, name=name), {}, ())


def recipe_from(
    document: Document, sets: Mapping[str, Any], effects: Sequence[Mapping[str, Any]]
) -> tuple[Recipe, list[Fault]]:
    """As `parse_recipe`, from a YAML document."""
    data = document.data
    if not isinstance(data, dict):
        form = Fault(document.where(()), "a recipe is a mapping", "keys such as name, rig, design, nodes")
        raise UserError([*document.faults, form])
    document, faults = with_overrides(document, sets, effects)
    faults += document.faults
    sections: dict[str, Any] = {}
    if "tacos" not in data:
        faults.append(
            Fault(document.where(()), "'tacos' is missing", f"tacos: {FORMAT}", "Add it as the first line.")
        )
    for key in data:
        if key not in Recipe.model_fields:
            remedy = did_you_mean(str(key), Recipe.model_fields)
            faults.append(Fault(document.where((key,)), f"unknown key {key!r}", "", remedy))
    for key, field in Recipe.model_fields.items():
        if key not in data:
            if field.is_required():
                faults.append(
                    Fault(document.where(()), f"{key!r} is missing", "", f"Add it: {field.description}")
                )
            continue
        annotation = _WITH_METADATA.get(key, field.annotation)
        value, found = _section(document, key, annotation, data[key])
        faults += found
        if value is not None:
            sections[key] = value
    recipe = _draft(sections)
    if not faults:
        _, found, _ = check(Recipe, data, lambda path: document.where(path))
        faults += found
    recipe._document = document
    return recipe, document.without_echoes(faults)


def _section(document: Document, key: str, annotation: Any, raw: Any) -> tuple[Any, list[Fault]]:
    """Check one section; where items of it are wrong, keep the others so that they are checked further."""

    def where(path: Sequence[str | int]) -> str:
        return document.where((key, *path))

    value, faults, paths = check(annotation, raw, where, key)
    if key == "design" and isinstance(raw, dict):
        plain = [len(path) == 1 and not isinstance(raw.get(path[0]), dict) for path in paths]
        faults = [
            _no_entry(fault) if is_plain else fault for fault, is_plain in zip(faults, plain, strict=True)
        ]
    if faults and isinstance(raw, dict) and key in ("nodes", "design", "constraints"):
        bad = {path[0] for path in paths if path}
        value, _, _ = check(annotation, {name: item for name, item in raw.items() if name not in bad}, where)
    return value, faults


def _no_entry(fault: Fault) -> Fault:
    """What to do about a design variable that is given a plain value."""
    return replace(
        fault,
        expected="an entry such as {between: [1, 2]} or {choose: [a, b]}",
        remedy="To fix it, move it under rig:, or among the settings of its node or effect.",
    )


def _draft(sections: dict[str, Any]) -> Recipe:
    """A recipe of the sections that were understood; the required ones that were not are empty."""
    empty: dict[str, Any] = {
        "name": "",
        "rig": None,
        "design": {},
        "nodes": {},
        "fitness": (),
        "optimizer": None,
    }
    return Recipe.model_construct(**{**empty, **sections})
