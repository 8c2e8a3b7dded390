"""Episodes that candidates are scored and trained on."""

from __future__ import annotations

from tacos_framework.recipe import Recipe
from tacos_framework.simulation import EpisodeSpec


def scored_episodes(recipe: Recipe, purpose: str, count: int, generation: int) -> tuple[EpisodeSpec, ...]:
    """Episodes to score the candidates of a generation on; the place in them is the number of an episode.

    - `recipe`: says into how many blocks each is cut, and whether generations see other episodes.
    - `purpose`: what they are for: other purposes are other episodes.
    - `count`: how many; each gives as many specs as there are blocks.
    - `generation`: the generation, counted from 0.
    """
    era = generation if recipe.study.renew_episodes == "each_generation" else 0
    blocks = recipe.study.blocks
    return tuple(
        EpisodeSpec(recipe.seed, (purpose, era, i), block=(block, blocks))
        for block in range(blocks)  # every world early
        for i in range(count)
    )


def training_episode(recipe: Recipe, generation: int, candidate: int) -> EpisodeSpec:
    """The episode that tasks train on with a candidate, counted in its generation."""
    match recipe.study.renew_training or recipe.study.renew_episodes:
        case "never":
            return EpisodeSpec(recipe.seed, ("train", 0, 0))
        case "each_generation":
            return EpisodeSpec(recipe.seed, ("train", generation, 0))
        case "each_candidate":
            return EpisodeSpec(recipe.seed, ("train", generation, candidate))
