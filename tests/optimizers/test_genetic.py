"""The genetic algorithm: elites, crossover, mutation, failures, starts."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from tacos_framework.catalog import Catalog, CatalogColumn, CatalogPart
from tacos_framework.contracts import Evaluated
from tacos_framework.errors import UserError
from tacos_framework.variables.design_space import (
    CatalogChoice,
    Categorical,
    Continuous,
    DesignSpace,
    Integer,
)
from tacos_plugins.optimizers.genetic import Genetic

LENSES = tuple(f"lens {i:02}" for i in range(20))
SPACE = DesignSpace(
    [
        Continuous("pitch_deg", -30, 30, "deg"),
        Continuous("baseline_m", 0.01, 3, "m"),
        Categorical("lens", LENSES),
    ]
)
STILL = {"factor": (1.0, 1.0), "add": 0.0, "discrete_step": 0.0}
"""Settings without any mutation: what is left is selection and crossover."""


def search(space: DesignSpace = SPACE, seed: int = 1, **config) -> Genetic:
    return Genetic(Genetic.Config(**config), space=space, rng=np.random.default_rng(seed))


def tell(optimizer: Genetic, fitness) -> list:
    asked = optimizer.ask()
    optimizer.tell([Evaluated(candidate, fitness(i, candidate)) for i, candidate in enumerate(asked)])
    return asked


def test_the_defaults_are_those_of_the_paper():
    config = Genetic.Config()
    assert (config.population, config.keep, config.parents, config.generations) == (10, 3, 5, 20)
    assert config.factor == (0.8, 1.2)
    assert config.add == 3.0
    assert len(search().ask()) == 10


def test_elites_are_asked_again_first_and_best_first():
    optimizer = search()
    asked = tell(optimizer, lambda i, _: [5, 1, 9, 0, 7, 2, 3, 4, 6, 8][i])
    assert optimizer.ask()[:3] == [asked[2], asked[9], asked[4]]


def test_each_gene_of_an_offspring_is_that_of_one_of_the_best():
    optimizer = search(**STILL)
    asked = tell(optimizer, lambda i, _: float(-i))
    parents = np.array([candidate.genes for candidate in asked[:5]])
    offspring = np.array([candidate.genes for candidate in optimizer.ask()[3:]])
    for gene in range(3):
        assert set(offspring[:, gene]) <= set(parents[:, gene])


def test_crossover_is_uniform_over_the_parents_and_independent_between_genes():
    optimizer = search(population=4000, keep=0, parents=4, generations=2, **STILL)
    asked = tell(optimizer, lambda i, _: float(-i))
    offspring = np.array([candidate.genes for candidate in optimizer.ask()])
    first, second = ([asked[p].genes[gene] for p in range(4)] for gene in (0, 1))
    origin = np.array([[first.index(genes[0]), second.index(genes[1])] for genes in offspring])
    counts = np.histogram2d(origin[:, 0], origin[:, 1], bins=4)[0]
    np.testing.assert_allclose(counts, 4000 / 16, atol=5 * np.sqrt(4000 / 16))


def offspring_of(value: float, space: DesignSpace, **config) -> np.ndarray:
    """Genes of many offspring of one parent."""
    optimizer = search(space, population=3000, keep=0, parents=1, generations=2, **config)
    parent = space.decode([value])
    optimizer.tell([Evaluated(parent, 1.0)])
    return np.array([candidate.genes[0] for candidate in optimizer.ask()])


def test_mutation_is_a_factor_and_an_offset():
    space = DesignSpace([Continuous("x", -1000, 1000, "m")])
    factors = offspring_of(100.0, space, add=0.0)
    assert factors.min() == pytest.approx(80, abs=0.1)
    assert factors.max() == pytest.approx(120, abs=0.1)
    assert factors.std() == pytest.approx(40 / np.sqrt(12), rel=0.05)
    offsets = offspring_of(100.0, space, factor=(1.0, 1.0), add=5.0)
    assert offsets.min() == pytest.approx(95, abs=0.05)
    assert offsets.max() == pytest.approx(105, abs=0.05)
    both = offspring_of(0.0, space)
    assert both.min() == pytest.approx(-3, abs=0.05)
    assert both.max() == pytest.approx(3, abs=0.05)


def test_mutants_stay_within_bounds():
    space = DesignSpace([Continuous("x", 0, 10, "m")])
    genes = offspring_of(10.0, space)
    assert genes.max() == 10.0
    assert genes.min() > 4.9


def test_integers_are_mutated_and_rounded():
    genes = offspring_of(5.0, DesignSpace([Integer("cameras", 1, 8)]), factor=(1.0, 1.0), add=1.4)
    assert set(genes) == {4.0, 5.0, 6.0}


def test_a_step_moves_a_choice_in_its_list():
    genes = offspring_of(10.0, DesignSpace([Categorical("lens", LENSES)]))
    assert set(genes) == {float(index) for index in range(7, 14)}


def test_a_step_reaches_the_first_and_the_last_value():
    space = DesignSpace([Categorical("lens", LENSES)])
    assert set(offspring_of(0.0, space)) == {0.0, 1.0, 2.0, 3.0}
    assert set(offspring_of(19.0, space)) == {16.0, 17.0, 18.0, 19.0}


def test_a_redraw_may_give_any_value_alike():
    genes = offspring_of(0.0, DesignSpace([Categorical("lens", LENSES)]), discrete_mutation="redraw")
    counts = np.bincount(genes.astype(int), minlength=20)
    np.testing.assert_allclose(counts, 150, atol=5 * np.sqrt(150))


def test_the_mutation_rate_is_that_of_genes():
    genes = offspring_of(0.5, DesignSpace([Continuous("x", 0, 1, "m")]), mutation_rate=0.25)
    assert np.mean(genes != 0.5) == pytest.approx(0.25, abs=0.04)


def test_genes_of_an_offspring_mutate_independently():
    space = DesignSpace([Continuous("x", -1, 1, "m"), Continuous("y", -1, 1, "m")])
    optimizer = search(space, population=2000, keep=0, parents=1, generations=2, mutation_rate=0.5)
    optimizer.tell([Evaluated(space.decode([0.5, 0.5]), 1.0)])
    changed = np.array([candidate.genes for candidate in optimizer.ask()]) != 0.5
    assert np.mean(changed[:, 0] & changed[:, 1]) == pytest.approx(0.25, abs=0.05)


def test_an_offset_of_one_gene_goes_before_that_of_its_variable():
    columns = ("width_mm", "pixel_um")
    sizes = np.linspace(2, 8, 61)
    rows = [CatalogPart(f"{w}, {p}", {"width_mm": w, "pixel_um": p}) for w in sizes for p in sizes]
    fields = tuple(CatalogColumn(name, name[-2:], "Size.") for name in columns)
    catalog = Catalog("sensors", "Sensors", fields, rows, source="tests", design_columns=columns)
    sensor = CatalogChoice("sensor", catalog)
    space = DesignSpace([sensor])
    config = {"population": 300, "keep": 0, "parents": 1, "generations": 2, "factor": (1.0, 1.0)}
    for add, reach in (({"sensor": 1}, [1, 1]), ({"sensor": 1, "sensor.pixel_um": 2}, [1, 2])):
        optimizer = search(space, add=add, **config)
        optimizer.tell([Evaluated(space.decode([5.0, 5.0]), 1.0)])
        genes = np.array([candidate.genes for candidate in optimizer.ask()])
        np.testing.assert_allclose(np.abs(genes - 5).max(axis=0), reach, atol=0.11)


def test_offsets_may_differ_between_variables():
    space = DesignSpace([Continuous("pitch_deg", -30, 30, "deg"), Continuous("baseline_m", -3, 3, "m")])
    config = {"population": 500, "keep": 0, "parents": 1, "generations": 2}
    optimizer = search(space, add={"pitch_deg": 5, "baseline_m": 0.2}, **config)
    optimizer.tell([Evaluated(space.decode([0.0, 0.0]), 1.0)])
    genes = np.abs([candidate.genes for candidate in optimizer.ask()]).max(axis=0)
    np.testing.assert_allclose(genes, [5, 0.2], rtol=0.02)


def test_wrong_offsets_are_all_refused_at_once():
    with pytest.raises(UserError) as raised:
        search(add={"pich_deg": 5, "lens": 2})
    unknown, no_number, *missing = map(str, raised.value.faults)
    assert unknown.startswith(
        "optimizer.genetic: add names 'pich_deg', which is no number of the design\n  to do: Did you mean"
    )
    assert "'pitch_deg'" in unknown
    assert no_number.startswith("optimizer.genetic: add names 'lens', which is no number of the design")
    assert missing == [
        f"optimizer.genetic: add has no entry for {name!r}\n"
        f"  expected: one per variable\n  to do: Add {name!r}."
        for name in ("pitch_deg", "baseline_m")
    ]


def test_failed_candidates_never_breed():
    optimizer = search(**STILL)
    asked = tell(optimizer, lambda i, _: 1.0 if i in (4, 7) else None)
    survivors = np.array([asked[4].genes, asked[7].genes])
    following = optimizer.ask()
    assert following[:2] == [asked[4], asked[7]]
    assert len(following) == 10
    for gene in range(3):
        assert {candidate.genes[gene] for candidate in following} <= set(survivors[:, gene])


def test_where_all_failed_the_next_generation_starts_over():
    optimizer = search()
    asked = tell(optimizer, lambda *_: None)
    following = optimizer.ask()
    assert len(following) == 10
    assert not set(following) & set(asked)


def test_equal_candidates_take_one_place_among_the_elites():
    space = DesignSpace([Categorical("lens", LENSES[:3])])
    optimizer = search(space, population=12, keep=3, parents=3)
    tell(optimizer, lambda _, candidate: float(candidate.genes[0]))
    assert [candidate.values["lens"] for candidate in optimizer.ask()[:3]] == [
        "lens 02",
        "lens 01",
        "lens 00",
    ]


def test_a_fitness_that_is_not_a_number_is_refused():
    with pytest.raises(ValueError, match="not a number"):
        tell(search(), lambda *_: float("nan"))


@pytest.mark.parametrize(
    ("start", "genes"), [("smallest", (-30.0, 0.01, 0.0)), ("largest", (30.0, 3.0, 19.0))]
)
def test_the_start_may_be_at_an_end_of_every_range(start, genes):
    assert {candidate.genes for candidate in search(start=start).ask()} == {genes}


def test_a_random_start_covers_the_space():
    genes = np.array([candidate.genes for candidate in search(population=400, generations=1).ask()])
    np.testing.assert_allclose(genes.min(axis=0), [-30, 0.01, 0], atol=1)
    np.testing.assert_allclose(genes.max(axis=0), [30, 3, 19], atol=1)


def test_it_stops_after_its_generations():
    optimizer = search(generations=2)
    tell(optimizer, lambda i, _: float(i))
    assert optimizer.stop() is None
    tell(optimizer, lambda i, _: float(i))
    assert optimizer.stop() == "all 2 generations were evaluated"


def test_a_product_that_leaves_nothing_free_is_one_candidate():
    optimizer = search(DesignSpace([]), generations=2)
    assert len(set(optimizer.ask())) == 1
    tell(optimizer, lambda *_: 1.0)
    assert len(set(optimizer.ask())) == 1


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"keep": 11}, "keep=11 of a population of 10"),
        ({"parents": 11}, "parents=11 of a population of 10"),
        ({"keep": 10}, "no room for offspring"),
        ({"factor": (1.2, 0.8)}, "factor must rise"),
        ({"add": -1.0}, "add must be 0 or more"),
        ({"add": {"x": -1.0}}, "add must be 0 or more"),
        ({"mutation_rate": 1.1}, "less than or equal to 1"),
        ({"discrete_mutation": "jump"}, "'step' or 'redraw'"),
    ],
)
def test_settings_that_make_no_sense_are_refused(wrong, said):
    with pytest.raises(ValidationError, match=said):
        Genetic.Config(**wrong)


def test_it_beats_random_search_on_a_smooth_problem():
    """Five variables, 200 evaluations, median of 15 runs: the paper's shape of problem."""
    from tacos_plugins.optimizers.random_search import RandomSearch

    space = DesignSpace([Continuous(name, 0, 10, "m") for name in "abcde"])

    def regret(optimizer) -> float:
        best = np.inf
        while optimizer.stop() is None:
            asked = optimizer.ask()
            losses = [float(np.sum((np.array(candidate.genes) - 6) ** 2)) for candidate in asked]
            best = min(best, *losses)
            optimizer.tell([Evaluated(c, -loss) for c, loss in zip(asked, losses, strict=True)])
        return best

    genetic = [regret(search(space, seed=seed)) for seed in range(15)]
    rng = np.random.default_rng
    drawn = [regret(RandomSearch(RandomSearch.Config(), space=space, rng=rng(seed))) for seed in range(15)]
    assert np.median(genetic) < 0.6 * np.median(drawn)
