"""The recipe of a study: what to design, how to simulate it, and what to score it by."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

from pydantic import ConfigDict, PrivateAttr, model_validator

from tacos_framework.recipe.effect_names import effect_names
from tacos_framework.recipe.notes import quoting
from tacos_framework.recipe.pipeline import Pipeline
from tacos_framework.recipe.sections import (
    Aim,
    Bounds,
    Compare,
    EffectUse,
    ExposureControl,
    Name,
    NodeUse,
    Scenario,
    Scenarios,
    StudySettings,
    Test,
    Use,
    Variable,
    Weighted,
)
from tacos_framework.recipe.written import Written
from tacos_framework.settings import Settings, setting
from tacos_framework.settings.yaml_document import Document

FORMAT = 1
"""The recipe format this version reads (``tacos: 1``)."""


class Recipe(Written, Settings):
    """A camera design problem: variables, simulation and scores.

    Built from YAML by `load_recipe` or in Python with keyword arguments; both are equal in power.
    """

    model_config = ConfigDict(populate_by_name=True)

    tacos: Literal[1] = setting(FORMAT, help="Format of the recipe.")
    name: str = setting(help="Name of the study.", min_length=1, max_length=200)
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
        None, help="Control of exposure time and gain by frame; fixed as in the scenario if absent."
    )
    effects: tuple[EffectUse, ...] = setting((), help="Effects of the camera; each acts at its own stage.")
    pipeline: Pipeline = setting(
        {},
        help="Processing in the camera: effects of the stages isp and codec with their settings, as "
        "in {tone-curve: {gamma: 0.45}}; or a shipped list, raw, coded or jpeg; or from: such a list.",
    )
    nodes: dict[Name, NodeUse] = setting(help="The graph: components, wired by their ports.", min_length=1)
    fitness: tuple[Weighted, ...] = setting(help="Weighted sum of scores, maximised.", min_length=1)
    objectives: tuple[Aim, ...] = setting((), help="Aims that a front trades off, the fitness among them.")
    optimizer: Use = setting(help="The derivative-free optimizer.")
    executor: Use | None = setting(None, help="Evaluates candidates; in this process if absent.")
    study: StudySettings = setting(StudySettings(), help="Episodes, finalists and failures of the study.")
    compare: Compare | None = setting(None, help="Off-the-shelf cameras to set beside the design.")
    test: Test | None = setting(None, help="Scenes the design is tested on.")
    notes: tuple[str, ...] = setting(
        (), help="Notes for readers of the results; {rig.binning} and the like quote the recipe."
    )

    _document: Document | None = PrivateAttr(None)

    def clashes(self) -> Iterator[str]:
        """Contradictions within it, in sentences; a draft may be asked as well."""
        if self.test is not None and self.test.seed == self.seed:
            yield f"test.seed and seed are both {self.seed}: the test scenes would not be unseen"

    @model_validator(mode="after")
    def _has_no_clash(self) -> Recipe:
        if clashes := list(self.clashes()):
            raise ValueError("; ".join(clashes))
        return self

    @model_validator(mode="after")
    def _notes_quote_what_is_there(self) -> Recipe:
        for note in self.notes:
            quoting(note, self.as_data())
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
    def all_effects(self) -> tuple[EffectUse, ...]:
        """The effects, those of the pipeline behind the others."""
        processed = (
            EffectUse.model_validate({"use": f"effect.{name}", **settings})
            for name, settings in self.pipeline.items()
        )
        return (*self.effects, *processed)

    @property
    def effect_names(self) -> tuple[str, ...]:
        """Names of the effects for design variables, ``effects.NAME.setting``."""
        return effect_names([(effect.use, effect.name) for effect in self.all_effects])

    def keys_of(self, section: str) -> tuple[str, ...]:
        """The keys of a section, those among them whose values are at fault and so no part of the recipe."""
        written = self._document.data.get(section) if self._document is not None else None
        return tuple(written if isinstance(written, dict) else getattr(self, section))

    @property
    def text(self) -> Document | None:
        return self._document

    def as_data(self) -> dict[str, Any]:
        """The recipe as plain data, every default filled in; `parse_recipe` of it gives an equal recipe."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)
