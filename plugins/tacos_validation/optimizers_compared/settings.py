"""Optimizers, problem and reference of a comparison."""

from __future__ import annotations

from pydantic import JsonValue, model_validator

from tacos_framework import Settings, Use, did_you_mean, setting


class HeldOut(Settings):
    """Scenes that no optimizer sees, on which what they recommend is judged."""

    seed: int = setting(2001, help="Seed of these scenes.", ge=0)
    episodes: int = setting(8, help="Number of these scenes.", ge=1)
    frames: int | None = setting(None, help="Frames of each; as in the problem if absent.", ge=1)


class ReferenceSearch(Settings):
    """The search on the held-out scenes themselves that says how good a camera can be there.

    Every value of every choice is tried at every point of a coarse grid; the best of them then climb on the
    fine one.
    """

    coarse: dict[str, float] = setting(
        {}, help="Step of each variable between bounds; every fourth of the fine grid's where absent."
    )
    scenes: int = setting(2, help="Held-out scenes the coarse grid is scored on.", ge=1)
    climbs: int = setting(
        6, help="Number of the best cameras that climb, each from another choice of parts.", ge=1
    )
    most: int = setting(20_000, help="More cameras than this on the coarse grid are refused.", ge=1)


class Target(Settings):
    """The quality to be reached."""

    optimizer: str = setting("genetic", help="Whose quality it is.")
    rounds: int = setting(20, help="After how many rounds.", ge=1)


class CompareOptimizersConfig(Settings):
    problem: str = setting(
        help="The recipe of the design problem: a path, or the name of a shipped one.", is_path=True
    )
    change: dict[str, JsonValue] = setting(
        {}, help="Keys of that recipe to change, as with --set, e.g. {rig.binning: 8}."
    )
    grid: dict[str, float] = setting(
        help="Step of each variable between bounds, in its unit: candidates are points of this grid."
    )
    held_out: HeldOut = setting(HeldOut(), help="Scenes that what is recommended is judged on.")
    reference: ReferenceSearch = setting(
        ReferenceSearch(), help="Search for the best camera on the held-out scenes."
    )
    optimizers: dict[str, Use] = setting(help="The optimizers by name, with their settings.", min_length=1)
    optional: tuple[str, ...] = setting(
        (), help="Optimizers to leave out, with a note, where the packages they need are not installed."
    )
    seeds: int = setting(20, help="Runs of each optimizer.", ge=1)
    checkpoints: tuple[int, ...] = setting(
        (40, 80, 160, 320, 640, 1280, 2064),
        help="Images rendered after which each run is asked what it recommends; the last is its budget.",
        min_length=1,
    )
    budgets: dict[str, int] = setting(
        {}, help="Larger budgets of single optimizers, in images; the checkpoints go on in equal ratios."
    )
    target: Target = setting(Target(), help="The quality to be reached.")
    against: tuple[str, ...] = setting(
        (), help="Optimizers whose images to the target are set in ratio to those of the others."
    )

    @model_validator(mode="after")
    def _names_are_known(self) -> CompareOptimizersConfig:
        for name in (self.target.optimizer, *self.optional, *self.budgets, *self.against):
            if name not in self.optimizers:
                remedy = did_you_mean(name, self.optimizers)
                raise ValueError(f"there is no optimizer {name!r}. {remedy}".rstrip())
        if self.target.optimizer in self.optional:
            raise ValueError("the optimizer whose quality is the target cannot be optional")
        return self

    @model_validator(mode="after")
    def _budgets_grow(self) -> CompareOptimizersConfig:
        if list(self.checkpoints) != sorted(set(self.checkpoints)) or self.checkpoints[0] < 1:
            raise ValueError("checkpoints are rising numbers of images")
        for name, images in self.budgets.items():
            if images < self.checkpoints[-1]:
                raise ValueError(
                    f"the budget of {name}, {images} images, ends before the last checkpoint, "
                    f"{self.checkpoints[-1]}"
                )
        if any(step <= 0 for step in (*self.grid.values(), *self.reference.coarse.values())):
            raise ValueError("steps of a grid are above 0")
        return self

    def checkpoints_of(self, optimizer: str) -> tuple[int, ...]:
        """The checkpoints of an optimizer's runs; beyond the common ones each doubles the one before."""
        own = list(self.checkpoints)
        budget = self.budgets.get(optimizer, own[-1])
        while own[-1] < budget:
            own.append(min(2 * own[-1], budget))
        return tuple(own)
