"""The sections of a study's recipe, each checked by itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from tacos_framework.settings import Settings, setting

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]


class Use(BaseModel):
    """A component and its settings: ``{use: kind.name, setting: value, ...}``."""

    model_config = ConfigDict(frozen=True, extra="allow")

    use: str = Field(description="The component, kind.name.", pattern=r"^[a-z]+\.[a-z0-9_-]+$")

    @property
    def settings(self) -> dict[str, Any]:
        """The settings given, without ``use`` and wiring."""
        return dict(self.model_extra or {})


class Train(BaseModel):
    """Training of a task during the study; further keys go to the task as its budget's settings."""

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
        description="Name in design variables; that of its component if absent.",
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
    scheme: Literal["quantized", "discrete"] | None = setting(
        None, help="Encoding of the rows for the optimizer (paper, Sec. 3.3); by default that of the catalog."
    )
    columns: tuple[str, ...] | None = setting(
        None, help="Columns that span the quantized space; those of the catalog's own choice if absent."
    )
    only: tuple[str, ...] | None = setting(
        None, help="Names of the parts to choose among, one or more; all of the catalog if absent."
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
    """A bound on a derived quantity or a column of a part."""

    model_config = ConfigDict(populate_by_name=True)

    min: float | None = setting(None, help="Smallest allowed value.")
    max: float | None = setting(None, help="Largest allowed value.")
    word: str | None = setting(None, help="The only allowed word, as in global.", alias="is")
    any_of: tuple[str, ...] = setting((), help="Allowed words, where there are several.")
    unknown: Literal["allow", "refuse"] = setting(
        "allow", help="Allow or refuse parts without a published value."
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
    aim: Literal["max", "min"] = setting(help="Maximise or minimise it.")


class Scenario(Settings):
    """Light and exposure, the same for every candidate."""

    illumination_lux: float = setting(
        20.0,
        help="Mean illuminance 1 m above the floor.",
        unit="lux",
        gt=0,
        also=("lux", "brightness", "light"),
    )
    gain_db: float = setting(
        5.0,
        help="Gain of the calibrated pixel; larger pixels need less.",
        unit="dB",
        also=("iso", "sensitivity", "amplification"),
    )
    exposure_ms: float = setting(
        30.0, help="Exposure time.", unit="ms", gt=0, also=("shutter", "integration")
    )
    f_number: float = setting(
        2.0, help="Focal length over aperture.", gt=0, also=("aperture", "fnumber", "fstop")
    )


class NamedScenario(Scenario):
    """One of several scenarios."""

    name: str = setting(help="Name in results and design variables.", pattern=r"^[a-z][a-z0-9_]*$")
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


class Weighted(Settings):
    """One term of the fitness."""

    score: str = setting(help="node.score, e.g. features.inliers.")
    weight: float = setting(help="Its weight in the sum; negative for scores to keep small.")


class StudySettings(Settings):
    """Rules of the comparison of candidates."""

    retired_keys: ClassVar[Mapping[str, str]] = {
        "race": "Take it out: races dropped the best candidate too often. To spend fewer images, lower "
        "`episodes`, or take an optimizer that asks for single episodes."
    }

    episodes: int = setting(1, help="Episodes each candidate is scored on.", ge=1)
    renew_episodes: Literal["never", "each_generation"] = setting(
        "each_generation", help="New worlds for each generation, or the same ones."
    )
    renew_training: Literal["never", "each_generation", "each_candidate"] | None = setting(
        None, help="New training worlds for tasks that learn; by default as renew_episodes."
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
        help="Reaction to a defect of a component on one candidate: fail the candidate, or stop the study.",
    )
    finalists: int = setting(
        3,
        help=(
            "Most promising candidates, scored once more on episodes of their own; the best of them wins. "
            "One alone is scored only where scores do not compare and no test follows."
        ),
        ge=1,
    )
    final_episodes: int | None = setting(
        None, help="Episodes the finalists are scored on; as many as `episodes` if absent.", ge=1
    )


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

    retired_keys: ClassVar[Mapping[str, str]] = {
        "margin": "Use `margins`, which has a difference for each score in its unit, as in "
        "{features.inliers: 5}; without it those hold that the tasks declare."
    }

    seed: int = setting(help="Seed of the test scenes.", ge=0)
    frames: int | None = setting(None, help="Frames per episode; as in the design if absent.", ge=1)
    episodes: int = setting(1, help="Episodes every camera is tested on first.", ge=1)
    most_episodes: int | None = setting(
        None,
        help="Episodes are added until the best product is decided, up to these; none are if absent.",
        ge=1,
    )
    margins: dict[str, Annotated[float, Field(ge=0)]] = setting(
        {},
        help="Differences of a score (node.score) that do not matter, in its unit; by default what its task "
        "declares. The margin of the fitness is the root of the sum of (weight x margin) squared.",
    )
    confidence: float = setting(
        0.95, help="Confidence of a verdict, over all products and planned looks.", gt=0.5, lt=1
    )

    @model_validator(mode="after")
    def _most_are_no_fewer(self) -> Test:
        if self.most_episodes is not None and self.most_episodes < self.episodes:
            raise ValueError(f"most_episodes is {self.most_episodes}, fewer than episodes, {self.episodes}")
        return self
